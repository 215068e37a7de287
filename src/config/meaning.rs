//! What a pipeline file means: dimensionless numbers, mobilities, memory and disk, all without a GPU.

use super::Loaded;
use super::check::{SOUND, restores};
use super::pace;
use crate::buffers::Life;
use crate::graph::{self, Output, Plan, memory};
use crate::math::mobility::Friction;
use crate::math::transport::{Rule, Transport};
use crate::params::Value;
use crate::state::packed::bins;
use crate::wire::Kind;
use crate::wire::domain::{SAMPLES, SAMPLES_WAITING};
use std::fmt;

/// Bytes of a message before its rows: header, column table, species table.
const MESSAGE_HEAD: u64 = 1024;
/// Bytes of a checkpoint besides the buffers: notes, the pipeline file, the books.
const CHECKPOINT_HEAD: u64 = 1 << 16;
/// Checkpoints for which there must be room: the newest, the one before, and one that is being written.
const CHECKPOINTS: u64 = 3;

/// Everything that `squirm check` prints.
#[derive(Debug, Clone)]
pub struct Meaning {
    /// Name of the run.
    pub name: String,
    /// Fluid particles.
    pub particles: u64,
    /// Fluid particles per a^3 at the start, and as declared; they differ where a table makes the start.
    pub density: [f64; 2],
    /// Collision cells.
    pub cells: u64,
    /// Steps, time step, temperature.
    pub run: (u64, f64, f64),
    /// Transport coefficients; `None` without a rotation.
    pub transport: Option<Transport>,
    /// Largest velocity of the pressure-driven flow between the walls, sqrt(kT/m); 0 without one.
    pub flow_speed: f64,
    /// Squirmers by species.
    pub species: Vec<SpeciesMeaning>,
    /// Share of the box that bodies fill.
    pub volume_fraction: f64,
    /// Bins of the squirmers' pair search.
    pub bins: [u32; 3],
    /// Buffers on the GPU with their bytes.
    pub memory: Vec<(&'static str, u64)>,
    /// Bytes of shared memory.
    pub shared: u64,
    /// Bytes written per step, averaged; before compression.
    pub disk_per_step: f64,
    /// Bytes of one checkpoint; 0 if there are none.
    pub checkpoint: u64,
    /// Seconds that a step takes on a data-centre GPU; an estimate.
    pub seconds_per_step: f64,
}

/// One species in numbers.
#[derive(Debug, Clone)]
pub struct SpeciesMeaning {
    /// Its name.
    pub name: String,
    /// How many.
    pub count: u32,
    /// Semi-axes along and across e, in a.
    pub axes: (f64, f64),
    /// Mass in m.
    pub mass: f64,
    /// Swim speed in an unbounded fluid, sqrt(kT/m).
    pub speed: f64,
    /// Mach number of the swim speed.
    pub mach: f64,
    /// Reynolds number gamma U0 b/eta with the longest semi-axis b.
    pub reynolds: Option<f64>,
    /// Peclet number U0/(2 b D_R) with the rotational diffusion D_R across e.
    pub peclet: Option<f64>,
    /// Friction per viscosity.
    pub friction: Friction,
    /// Diffusion along e, across e (a^2/tau), about e, and across e (1/tau).
    pub diffusion: Option<[f64; 4]>,
}

/// What a loaded file means.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn meaning(loaded: &Loaded) -> Meaning {
    let Loaded { plan, particles, .. } = loaded;
    let system = &plan.system;
    let density = match &system.init.from {
        Some(_) => *particles as f64 / system.fluid_volume(),
        None => system.fluid.density,
    };
    let transport = rule(plan, density).map(|rule| rule.transport());
    // As on a GPU.
    let elements = graph::fused::sizes(plan, *particles, None);
    let bound = graph::fused::bound(plan, &elements).unwrap_or_default();
    let buffers = memory(bound.iter().map(String::as_str), &elements);
    let persistent = buffers.iter().filter(|(buffer, _)| buffer.life == Life::Persistent);
    let carried = persistent.map(|(buffer, _)| elements.bytes(buffer));
    let checkpoint = if plan.checkpoints.enabled { CHECKPOINT_HEAD + carried.sum::<u64>() } else { 0 };
    let mut memory: Vec<_> =
        buffers.into_iter().filter(|(_, bytes)| *bytes > 0).map(|(b, bytes)| (b.name, bytes)).collect();
    memory.extend(snapshots(plan, *particles));
    let flow_speed = match (&system.domain.walls, transport) {
        (Some(walls), Some(t)) if walls.condition == "no-slip" => {
            let g = system.fluid.acceleration[0].hypot(system.fluid.acceleration[2]);
            // Poiseuille: u_max = gamma g L^2/(8 eta).
            density * g * f64::from(system.domain.size[1]).powi(2) / (8.0 * t.viscosity)
        }
        _ => 0.0,
    };
    Meaning {
        name: plan.name.clone(),
        particles: *particles,
        density: [density, system.fluid.density],
        cells: system.domain.cells().iter().map(|n| u64::from(*n)).product(),
        run: (system.run.steps, system.run.dt, system.fluid.temperature),
        transport,
        flow_speed,
        species: (0..system.species.len()).map(|i| species(plan, i, density, transport)).collect(),
        volume_fraction: 1.0 - system.fluid_volume() / system.domain.volume(),
        bins: bins(system),
        memory,
        shared: shared(plan, *particles),
        disk_per_step: plan.outputs.iter().map(|o| disk(plan, o, *particles)).sum(),
        checkpoint,
        seconds_per_step: pace::step(&elements, graph::places(plan)),
    }
}

/// The collision rule of the list, if it rotates.
fn rule(plan: &Plan, density: f64) -> Option<Rule> {
    let rotate = plan.stages.iter().find(|s| s.entry.kind == "rotate")?;
    let angle = match rotate.values.get("angle") {
        Some(Value::Float(angle)) => *angle,
        _ => return None,
    };
    let angular_momentum = plan.stages.iter().any(|s| restores(s.entry.kind, &s.values).0);
    let (temperature, dt) = (plan.system.fluid.temperature, plan.system.run.dt);
    (density > 0.0 && angle > 0.0).then_some(Rule { density, temperature, dt, angle, angular_momentum })
}

fn species(plan: &Plan, index: usize, density: f64, transport: Option<Transport>) -> SpeciesMeaning {
    let (system, species) = (&plan.system, &plan.system.species[index]);
    let shape = species.spheroid();
    let friction = Friction::of(shape);
    let speed = shape.swim_speed(species.b1);
    let longest = shape.along.max(shape.across);
    let temperature = system.fluid.temperature;
    let active = speed != 0.0;
    let diffusion = transport.map(|t| {
        [friction.along, friction.across, friction.spin, friction.tumble].map(|zeta| temperature / (zeta * t.viscosity))
    });
    SpeciesMeaning {
        name: species.name.clone(),
        count: species.count,
        axes: (shape.along, shape.across),
        mass: f64::from(species.ghosts(&system.fluid)),
        speed,
        mach: speed.abs() / (SOUND * temperature.sqrt()),
        reynolds: transport.filter(|_| active).map(|t| density * speed.abs() * longest / t.viscosity),
        peclet: diffusion.filter(|_| active).map(|d| speed.abs() / (2.0 * longest * d[3])),
        friction,
        diffusion,
    }
}

/// Particles in a snapshot.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
fn taken(output: &Output, particles: u64) -> u64 {
    (particles as f64 * output.fraction).ceil() as u64
}

/// Bytes of one message of a topic.
fn message(plan: &Plan, output: &Output, topic: &str, particles: u64) -> u64 {
    let rows = match topic {
        "squirmers" => u64::from(plan.system.squirmer_count()) * 120,
        "scalars" => 2048,
        "fields" => plan.system.domain.size.iter().map(|n| u64::from(n.div_ceil(output.block))).product::<u64>() * 16,
        // Where all are sent, the positions come in full.
        _ => taken(output, particles) * if output.fraction < 1.0 { 24 } else { 36 },
    };
    MESSAGE_HEAD + rows
}

/// Buffers in which the GPU prepares snapshots.
fn snapshots(plan: &Plan, particles: u64) -> Vec<(&'static str, u64)> {
    let bytes = |topic: &str| {
        let asked = |o: &&Output| [&o.publish, &o.record].iter().any(|words| words.iter().any(|w| w == topic));
        let of = |o: &Output| match topic {
            "particles" => taken(o, particles) * 24,
            _ => message(plan, o, topic, particles) - MESSAGE_HEAD,
        };
        plan.outputs.iter().filter(asked).map(of).sum::<u64>()
    };
    [("fields", bytes("fields")), ("samples", bytes("particles"))].into_iter().filter(|(_, n)| *n > 0).collect()
}

fn shared(plan: &Plan, particles: u64) -> u64 {
    let topic = |topic: &str| {
        let publish = || plan.outputs.iter().filter(|o| o.publish.iter().any(|t| t == topic));
        let longest = publish().map(|o| message(plan, o, topic, particles)).max().unwrap_or(0);
        let samples = if publish().any(|o| o.on_slow != "drop") { SAMPLES_WAITING } else { SAMPLES };
        longest * samples as u64
    };
    if plan.system.run.live { Kind::ALL.iter().map(|kind| topic(kind.topic())).sum() } else { 0 }
}

#[allow(clippy::cast_precision_loss)]
fn disk(plan: &Plan, output: &Output, particles: u64) -> f64 {
    let recorded: u64 = output.record.iter().map(|t| message(plan, output, t, particles)).sum();
    // A number in a table takes about 12 characters where the message takes four bytes.
    let tables: u64 = output.csv.iter().map(|t| 3 * (message(plan, output, t, particles) - MESSAGE_HEAD)).sum();
    (recorded + tables) as f64 / output.every as f64
}

/// Bytes in the largest unit that keeps the number above one.
#[allow(clippy::cast_precision_loss)]
pub fn bytes(count: u64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB", "PB"];
    let (mut value, mut unit) = (count as f64, 0);
    while value >= 1000.0 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 { format!("{value:.0} B") } else { format!("{value:.3} {}", units[unit]) }
}

/// A whole number in groups of three digits.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

impl fmt::Display for Meaning {
    #[allow(clippy::cast_precision_loss)]
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (steps, dt, temperature) = self.run;
        writeln!(f, "{}", self.name)?;
        let time = steps as f64 * dt;
        writeln!(f, "  run        {} steps of {dt} tau = {time} tau", grouped(steps))?;
        writeln!(f, "  size       {} cells, {} particles", grouped(self.cells), grouped(self.particles))?;
        let [density, declared] = self.density;
        if (density - declared).abs() > 0.05 * declared {
            writeln!(
                f,
                "             {density:.4} particles per a^3 in the table; ghosts and masses are for density = {declared}"
            )?;
        }
        match &self.transport {
            Some(t) => {
                let (nu, kin, col) = (t.kinematic(), t.kinetic, t.collisional);
                writeln!(
                    f,
                    "  viscosity  eta {:.4} sqrt(m kT)/a^2, nu {nu:.4} a^2/tau (formula: {kin:.4} kinetic + {col:.4} collisional)",
                    t.viscosity
                )?;
                if dt * temperature.sqrt() <= 0.05 {
                    writeln!(
                        f,
                        "             at steps as small as this one measured up to 5 % lower (docs/physics.md)"
                    )?;
                }
                writeln!(
                    f,
                    "  diffusion  D {:.5} a^2/tau of a fluid particle; Schmidt number {:.1}",
                    t.diffusion,
                    t.schmidt()
                )?;
            }
            None => writeln!(f, "  viscosity  none: no stage `rotate` lets the particles collide")?,
        }
        if self.flow_speed > 0.0 {
            let mach = self.flow_speed / (SOUND * temperature.sqrt());
            writeln!(f, "  flow       Poiseuille, largest velocity {:.4} sqrt(kT/m), Mach {mach:.3}", self.flow_speed)?;
        }
        for species in &self.species {
            write!(f, "{species}")?;
        }
        if !self.species.is_empty() {
            let search = match self.bins {
                [0, ..] => "all pairs".to_owned(),
                [x, y, z] => format!("{x} x {y} x {z} bins"),
            };
            writeln!(f, "  bodies     {:.1} % of the volume; {search}", 100.0 * self.volume_fraction)?;
        }
        self.resources(f)
    }
}

impl Meaning {
    /// Bytes that the whole run may need on the disk: its outputs before compression, and its checkpoints.
    #[must_use]
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn disk(&self) -> u64 {
        ((self.disk_per_step * self.run.0 as f64) as u64).saturating_add(self.checkpoints())
    }

    /// Bytes of all checkpoints that are there at a time.
    #[must_use]
    pub fn checkpoints(&self) -> u64 {
        CHECKPOINTS * self.checkpoint
    }

    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn resources(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total: u64 = self.memory.iter().map(|(_, n)| n).sum();
        write!(f, "  GPU        {}", bytes(total))?;
        let mut largest = self.memory.clone();
        largest.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
        let names: Vec<String> = largest.iter().take(3).map(|(name, n)| format!("{name} {}", bytes(*n))).collect();
        writeln!(f, " ({})", names.join(", "))?;
        writeln!(f, "  shared     {} of shared memory for analyzers", bytes(self.shared))?;
        let steps_per_hour = 3600.0 / self.seconds_per_step;
        let duration = pace::words(self.run.0 as f64 * self.seconds_per_step);
        writeln!(
            f,
            "  time       {duration} for the run on one H100, {:.0} steps/s: an estimate; `squirm bench` measures",
            steps_per_hour / 3600.0
        )?;
        let run = self.disk_per_step * self.run.0 as f64;
        // What would come in an hour means nothing to a run of seconds.
        let hourly = match self.run.0 as f64 > steps_per_hour {
            true => format!("; about {} per hour on such a GPU", bytes((self.disk_per_step * steps_per_hour) as u64)),
            false => String::new(),
        };
        writeln!(f, "  disk       {} for the outputs of the run, before compression{hourly}", bytes(run as u64))?;
        match self.checkpoint {
            0 => writeln!(f, "             no checkpoints"),
            one => writeln!(
                f,
                "             {} for {CHECKPOINTS} checkpoints of {}",
                bytes(self.checkpoints()),
                bytes(one)
            ),
        }
    }
}

impl fmt::Display for SpeciesMeaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (along, across) = self.axes;
        let shape = match along.total_cmp(&across) {
            std::cmp::Ordering::Greater => "prolate",
            std::cmp::Ordering::Less => "oblate",
            std::cmp::Ordering::Equal => "sphere",
        };
        writeln!(f, "  {}: {} x {shape}, {along} along, {across} across, mass {} m", self.name, self.count, self.mass)?;
        if let (Some(reynolds), Some(peclet)) = (self.reynolds, self.peclet) {
            let (speed, mach) = (self.speed, self.mach);
            writeln!(
                f,
                "    swims      U0 {speed:.5} sqrt(kT/m), Reynolds {reynolds:.3}, Peclet {peclet:.1}, Mach {mach:.4}"
            )?;
        }
        if let Some([along, across, spin, tumble]) = self.diffusion {
            writeln!(f, "    mobility   D {along:.3e} along e, {across:.3e} across, a^2/tau (Perrin)")?;
            writeln!(f, "               D_R {spin:.3e} about e, {tumble:.3e} across, 1/tau")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_readable() {
        assert_eq!(grouped(1_234_567), "1 234 567");
        assert_eq!(grouped(12), "12");
        assert_eq!(bytes(999), "999 B");
        assert_eq!(bytes(1_500_000), "1.500 MB");
    }
}

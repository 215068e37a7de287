//! What a run was, in numbers that a person can judge: `summary.json`, and the same as text.

use super::books::{Balance, Books};
use super::{RunError, frames};
use crate::gpu::session::StepTime;
use crate::graph::Plan;
use crate::sink;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// How fast the run went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Default)]
pub struct Speed {
    /// Adapter.
    pub adapter: String,
    /// Steps done.
    pub steps: u64,
    /// Wall time in seconds, of all parts of a resumed run.
    pub seconds: f64,
    /// Fluid particles.
    pub particles: u64,
    /// Mean GPU time per step and stage in nanoseconds, of the last part of a resumed run; empty if the adapter has no timestamps.
    pub stages: Vec<StageTime>,
    #[serde(skip)]
    timed: u64,
}

/// Mean GPU time of one stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Kind.
    pub stage: String,
    /// Mean over the timed steps, in nanoseconds.
    pub nanoseconds: f64,
}

impl Speed {
    pub(super) fn new(adapter: String) -> Self {
        Self { adapter, ..Self::default() }
    }

    pub(super) fn add(&mut self, times: &StepTime) {
        self.timed += 1;
        #[allow(clippy::cast_precision_loss)]
        let weight = 1.0 / self.timed as f64;
        // Stages that do not run in this step take no time in it.
        self.stages.iter_mut().for_each(|s| s.nanoseconds *= 1.0 - weight);
        for (stage, time) in &times.stages {
            match self.stages.iter_mut().find(|s| s.stage == *stage) {
                Some(mean) => mean.nanoseconds += time * weight,
                None => self.stages.push(StageTime { stage: stage.clone(), nanoseconds: time * weight }),
            }
        }
    }

    pub(super) fn finish(&mut self, steps: u64, seconds: f64) {
        self.steps = steps;
        self.seconds = seconds;
        if self.timed == 0 {
            self.stages.clear();
        }
    }

    /// Steps per second.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn steps_per_second(&self) -> f64 {
        self.steps as f64 / self.seconds.max(1e-9)
    }

    /// Wall time per particle and step in nanoseconds.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn nanoseconds_per_particle_step(&self) -> f64 {
        self.seconds * 1e9 / (self.steps.max(1) as f64 * self.particles.max(1) as f64)
    }
}

/// How fast a species swam.
#[derive(Debug, Clone, Serialize)]
pub struct SwimSpeed {
    /// Species.
    pub species: String,
    /// <V.e> in sqrt(kT/m).
    pub measured: f64,
    /// Its standard error, by blocking.
    pub error: f64,
    /// Theory in an unbounded fluid at rest.
    pub u0: f64,
    /// Theory with the backflow of the periodic box; absent in a slit, where theory has walls to account for.
    pub u_periodic: Option<f64>,
}

/// Momentum and energy at the start and at the end.
#[derive(Debug, Clone, Serialize)]
pub struct Bookkeeping {
    /// Kinetic energy of fluid and squirmers per particle at the start, in kT.
    pub energy_start: f64,
    /// The same at the end.
    pub energy_end: f64,
    /// Momentum of the fluid at the end.
    pub fluid_momentum: [f64; 3],
    /// Momentum of the squirmers at the end.
    pub squirmer_momentum: [f64; 3],
    /// Momentum that walls have received.
    pub wall_impulse: [f64; 3],
    /// Momentum that the body force has put in.
    pub body_force_impulse: [f64; 3],
    /// What is missing in the sum of all that, per particle; 0 for exact arithmetic. Absent if a squirmer is held.
    pub momentum_error_per_particle: Option<f64>,
}

/// A finished run.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Name of the run.
    pub run: String,
    /// Version of the program.
    pub version: &'static str,
    /// Speed.
    pub speed: Speed,
    /// Steps per second.
    pub steps_per_second: f64,
    /// Wall time per particle and step in nanoseconds.
    pub ns_per_particle_step: f64,
    /// Bytes of all GPU buffers.
    pub gpu_bytes: u64,
    /// Mean temperature of the second half and its error, in kT.
    pub temperature: [f64; 2],
    /// Swim speeds, species by species.
    pub swim_speed: Vec<SwimSpeed>,
    /// Momentum and energy.
    pub books: Option<Bookkeeping>,
    /// Whether the run was stopped before its last step.
    pub stopped: bool,
    /// Remarks.
    pub remarks: Vec<String>,
    /// Snapshots handed to readers, files and tables.
    pub snapshots: u64,
    /// Snapshots that readers were too slow for.
    pub dropped: u64,
    /// What was lost although it was not to be: snapshots of topics that wait for their readers, and what declared analyzers missed.
    pub lost: Vec<String>,
    /// Files written.
    pub files: Vec<String>,
    /// Digest of the final state, independent of the order of the particles in memory.
    pub digest: String,
}

impl Summary {
    pub(super) fn new(
        plan: &Plan,
        books: &Books,
        mut speed: Speed,
        gpu_bytes: u64,
        sinks: sink::Summary,
        digest: String,
    ) -> Self {
        let (temperature, error) = books.temperature();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        if let Some((_, end)) = books.balances {
            speed.particles = end.count.round() as u64;
        }
        let mut remarks = Vec::new();
        if books.stuck {
            remarks
                .push("a particle was still inside a squirmer after all its hits and was put onto the surface".into());
        }
        if speed.steps < plan.system.run.steps {
            remarks.push(format!("stopped after {} of {} steps", speed.steps, plan.system.run.steps));
        }
        let files =
            sinks.files.iter().map(|f| format!("{} ({} messages, {} bytes)", f.path.display(), f.messages, f.bytes));
        Self {
            run: plan.name.clone(),
            version: env!("CARGO_PKG_VERSION"),
            steps_per_second: speed.steps_per_second(),
            ns_per_particle_step: speed.nanoseconds_per_particle_step(),
            gpu_bytes,
            temperature: [temperature, error],
            swim_speed: swim_speeds(plan, books),
            books: books.balances.map(|(start, end)| bookkeeping(plan, &start, &end)),
            stopped: speed.steps < plan.system.run.steps,
            remarks,
            snapshots: sinks.snapshots,
            dropped: sinks.dropped,
            lost: sinks.lost.iter().map(|(kind, count)| lost_to_readers(kind.topic(), *count)).collect(),
            files: files.collect(),
            digest,
            speed,
        }
    }

    /// Enters what analyzers have lost.
    pub(super) fn lose(&mut self, lost: Vec<String>, dir: &Path) -> Result<(), RunError> {
        if lost.is_empty() {
            return Ok(());
        }
        self.lost.extend(lost);
        self.write(dir)
    }

    pub(super) fn write(&self, dir: &Path) -> Result<(), RunError> {
        let path = dir.join("summary.json");
        let text = serde_json::to_string_pretty(self).expect("a summary has no keys that JSON lacks");
        std::fs::write(&path, text + "\n").map_err(|source| RunError::File { what: "write", path, source })
    }
}

fn lost_to_readers(topic: &str, count: u64) -> String {
    let snapshots = if count == 1 { "a snapshot".into() } else { format!("{count} snapshots") };
    format!(
        "{topic}: {snapshots} did not reach a reader, although the output waits for readers (slow_limit, full shared memory)"
    )
}

fn swim_speeds(plan: &Plan, books: &Books) -> Vec<SwimSpeed> {
    let domain = &plan.system.domain;
    let species = plan.system.species.iter().enumerate();
    species
        .map(|(i, s)| {
            let (measured, error) = books.swim_speed(i);
            let u_periodic = domain.walls.is_none().then(|| s.spheroid().swim_speed_periodic(s.b1, domain.volume()));
            SwimSpeed { species: s.name.clone(), measured, error, u0: s.spheroid().swim_speed(s.b1), u_periodic }
        })
        .collect()
}

fn bookkeeping(plan: &Plan, start: &Balance, end: &Balance) -> Bookkeeping {
    let force = DVec3::from_array(plan.system.fluid.acceleration) * end.count * (end.time - start.time);
    let walls = end.walls[0] + end.walls[1];
    let gained = (end.fluid_momentum + end.body_momentum) - (start.fluid_momentum + start.body_momentum);
    let held = plan.system.species.iter().any(|s| s.held);
    let count = end.count.max(1.0);
    Bookkeeping {
        energy_start: (start.fluid_energy + start.body_energy) / count,
        energy_end: (end.fluid_energy + end.body_energy) / count,
        fluid_momentum: end.fluid_momentum.to_array(),
        squirmer_momentum: end.body_momentum.to_array(),
        wall_impulse: walls.to_array(),
        body_force_impulse: force.to_array(),
        momentum_error_per_particle: (!held).then(|| (gained + walls - force).length() / count),
    }
}

/// A mean with its error, where there are values enough to know it.
fn estimate(mean: f64, error: f64, digits: usize) -> String {
    if error.is_finite() {
        format!("{mean:.digits$} +- {error:.digits$}")
    } else {
        format!("{mean:.digits$} (too few values for an error)")
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = &self.speed;
        writeln!(f, "{} on {}", self.run, s.adapter)?;
        writeln!(
            f,
            "  {} steps of {} particles in {:.1} s: {:.1} steps/s, {:.3} ns per particle and step, {:.0} MB on the GPU",
            s.steps,
            s.particles,
            s.seconds,
            self.steps_per_second,
            self.ns_per_particle_step,
            frames::megabytes(self.gpu_bytes)
        )?;
        let total: f64 = s.stages.iter().map(|t| t.nanoseconds).sum();
        if total > 0.0 {
            writeln!(f, "  GPU time by stage ({:.3} ms per step):", total * 1e-6)?;
            for t in &s.stages {
                let share = 100.0 * t.nanoseconds / total;
                writeln!(f, "    {:<20} {:5.1} %  {}", t.stage, share, "#".repeat((share / 2.5).round() as usize))?;
            }
        }
        writeln!(f, "  temperature        {} kT", estimate(self.temperature[0], self.temperature[1], 4))?;
        for v in &self.swim_speed {
            write!(f, "  swim speed <V.e>   {} sqrt(kT/m) ({}); ", estimate(v.measured, v.error, 5), v.species)?;
            match v.u_periodic {
                Some(u) => writeln!(f, "theory {:.5} unbounded, {u:.5} in this periodic box", v.u0)?,
                None => writeln!(f, "theory {:.5} in an unbounded fluid", v.u0)?,
            }
        }
        if let Some(b) = &self.books {
            writeln!(
                f,
                "  energy per particle  {:.5} kT at the start, {:.5} at the end",
                b.energy_start, b.energy_end
            )?;
            write!(f, "  momentum           fluid {:.3?}, squirmers {:.3?}, ", b.fluid_momentum, b.squirmer_momentum)?;
            writeln!(f, "to walls {:.3?}, from body force {:.3?}", b.wall_impulse, b.body_force_impulse)?;
            if let Some(error) = b.momentum_error_per_particle {
                writeln!(f, "  momentum missing   {error:.1e} sqrt(m kT) per particle")?;
            }
        }
        for remark in &self.remarks {
            writeln!(f, "  note: {remark}")?;
        }
        for lost in &self.lost {
            writeln!(f, "  LOST               {lost}")?;
        }
        for file in &self.files {
            writeln!(f, "  wrote {file}")?;
        }
        write!(f, "  state digest       {}", self.digest)
    }
}

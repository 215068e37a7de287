//! One reading in physical units: what books and messages are made of.

use crate::buffers::{Fault, SquirmerState};
use crate::gpu::Measurement;
use crate::gpu::measure::Parts;
use crate::state::{Squirmer, System, packed};
use crate::wire::{Fields, Particles, Scalars, SpeciesRow, Squirmers};
use glam::DVec3;

/// Sums over the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Totals {
    /// Particles.
    pub count: f64,
    /// sum v.
    pub momentum: DVec3,
    /// sum |v|^2 / 2 in kT.
    pub energy: f64,
    /// Temperature of the motion relative to the cells' means, in kT.
    pub temperature: f64,
}

/// One reading.
pub struct Frame {
    /// Steps done.
    pub step: u64,
    /// Simulated time in tau.
    pub time: f64,
    /// The fluid, if it was measured.
    pub totals: Totals,
    /// The squirmers.
    pub squirmers: Vec<Squirmer>,
    /// Their unwrapped centres in a.
    pub unwrapped: Vec<DVec3>,
    /// Force on each: steric and fluid, in kT/a.
    pub force: Vec<DVec3>,
    /// Torque on each, in kT.
    pub torque: Vec<DVec3>,
    /// Momentum that the low and the high wall have received since the start.
    pub wall_impulses: [DVec3; 2],
    /// The words of `faults`.
    pub faults: Vec<u32>,
    fields: Vec<f32>,
    samples: Vec<u32>,
}

impl Frame {
    /// Reads the parts of a reading.
    #[must_use]
    pub fn new(system: &System, parts: &Parts) -> Self {
        let states = squirmer_states(system, parts);
        let unwrapped = states.iter().map(|s| unwrap(system, s)).collect();
        let loads = |offset: usize| -> Vec<DVec3> {
            let steric = parts.get::<f32>("steric");
            let fluid = parts.get::<f32>("fluid_force");
            let at = |v: &[f32], i: usize| DVec3::from_array([0, 1, 2].map(|k| f64::from(v[8 * i + offset + k])));
            (0..states.len()).map(|i| at(&steric, i) + at(&fluid, i)).collect()
        };
        #[allow(clippy::cast_precision_loss)]
        let time = parts.step as f64 * system.run.dt;
        Self {
            step: parts.step,
            time,
            totals: totals(&parts.get::<u32>("totals"), Measurement::scale(system)),
            force: loads(0),
            torque: loads(4),
            squirmers: packed::unpack_squirmers(system, &states),
            unwrapped,
            wall_impulses: packed::wall_impulses(system, &parts.get::<u32>("wall_impulses")),
            faults: parts.get::<u32>("faults"),
            fields: parts.get("fields"),
            samples: parts.get("samples"),
        }
    }

    /// Whether some particle had to be pushed out of a squirmer.
    #[must_use]
    pub fn stuck(&self) -> bool {
        self.faults.first().is_some_and(|flags| flags & Fault::Stuck as u32 != 0)
    }

    /// Kinetic energy of the squirmers' motion and rotation, in kT, and their momentum.
    #[must_use]
    pub fn bodies(&self, system: &System) -> (f64, DVec3) {
        let mut energy = 0.0;
        let mut momentum = DVec3::ZERO;
        for s in &self.squirmers {
            let species = &system.species[s.species];
            let mass = f64::from(species.ghosts(&system.fluid));
            energy += 0.5 * mass * s.velocity.length_squared();
            energy += 0.5 * s.angular_momentum.dot(angular_velocity(system, s));
            momentum += mass * s.velocity;
        }
        (energy, momentum)
    }

    /// The `squirmers` message.
    #[must_use]
    pub fn squirmers_message(&self, system: &System) -> Squirmers {
        let single = |v: DVec3| v.as_vec3().to_array();
        let bodies = &self.squirmers;
        Squirmers {
            id: (0..u32::try_from(bodies.len()).expect("squirmers fit in 32 bits")).collect(),
            species: bodies.iter().map(|s| u32::try_from(s.species).expect("species are few")).collect(),
            position: bodies.iter().map(|s| single(s.position)).collect(),
            unwrapped: self.unwrapped.iter().map(DVec3::to_array).collect(),
            axis: bodies.iter().map(|s| single(s.axis())).collect(),
            orientation: bodies.iter().map(|s| s.orientation.as_quat().to_array()).collect(),
            velocity: bodies.iter().map(|s| single(s.velocity)).collect(),
            angular_velocity: bodies.iter().map(|s| single(angular_velocity(system, s))).collect(),
            force: self.force.iter().map(|f| single(*f)).collect(),
            torque: self.torque.iter().map(|t| single(*t)).collect(),
            table: system.species.iter().map(species_row).collect(),
        }
    }

    /// The `scalars` message.
    #[must_use]
    pub fn scalars_message(&self, system: &System) -> Scalars {
        let mut out = Scalars::default();
        let (energy, momentum) = self.bodies(system);
        out.push("temperature", "kT", self.totals.temperature);
        out.push("fluid_energy", "kT", self.totals.energy);
        out.push("squirmer_energy", "kT", energy);
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            out.push(&format!("fluid_momentum_{name}"), "sqrt(m kT)", self.totals.momentum[axis]);
            out.push(&format!("squirmer_momentum_{name}"), "sqrt(m kT)", momentum[axis]);
            out.push(&format!("wall_low_impulse_{name}"), "sqrt(m kT)", self.wall_impulses[0][axis]);
            out.push(&format!("wall_high_impulse_{name}"), "sqrt(m kT)", self.wall_impulses[1][axis]);
        }
        out.push("swim_speed", "sqrt(kT/m)", self.swim_speed());
        out
    }

    /// Mean speed of the squirmers along their axes in sqrt(kT/m); 0 without squirmers.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn swim_speed(&self) -> f64 {
        self.squirmers.iter().map(|s| s.velocity.dot(s.axis())).sum::<f64>() / self.squirmers.len().max(1) as f64
    }

    /// The `fields` message; the density is that of the part of a block that lies in the box.
    #[must_use]
    #[allow(clippy::cast_possible_truncation)]
    pub fn fields_message(&self, system: &System, blocks: [u32; 3], edge: u32) -> Fields {
        let mut out = Fields { block: edge, blocks, density: Vec::new(), velocity: Vec::new() };
        let size = system.domain.size;
        for (i, block) in self.fields.chunks_exact(4).take(blocks.iter().product::<u32>() as usize).enumerate() {
            let i = i as u32;
            let place = [i % blocks[0], i / blocks[0] % blocks[1], i / (blocks[0] * blocks[1])];
            let volume: u32 = (0..3).map(|k| edge.min(size[k] - place[k] * edge)).product();
            let [n, x, y, z] = [block[0], block[1], block[2], block[3]];
            out.density.push((f64::from(n) / f64::from(volume)) as f32);
            out.velocity.push(if n > 0.0 { [x / n, y / n, z / n] } else { [0.0; 3] });
        }
        out
    }

    /// The `particles` message.
    #[must_use]
    pub fn particles_message(&self, system: &System, fraction: f64, samples: u64, population: u64) -> Particles {
        let mut out = Particles { fraction, population, ..Particles::default() };
        let lengths = system.domain.size.map(f64::from);
        for p in self.samples.chunks_exact(6).take(usize::try_from(samples).expect("samples fit in memory")) {
            let position = packed::unpack_position(&system.domain, [p[0], p[1], p[2]]);
            out.push(position.to_array(), [p[3], p[4], p[5]].map(f32::from_bits), lengths, samples == population);
        }
        out
    }
}

fn species_row(s: &crate::state::Species) -> SpeciesRow {
    SpeciesRow {
        name: s.name.clone(),
        along: s.semi_axes.along,
        across: s.semi_axes.across,
        b1: s.b1,
        beta: s.beta,
        rotlet: s.rotlet,
        u0: s.spheroid().swim_speed(s.b1),
    }
}

fn angular_velocity(system: &System, s: &Squirmer) -> DVec3 {
    let species = &system.species[s.species];
    let (along, across) = species.hull().inertia(f64::from(species.ghosts(&system.fluid)));
    let body = s.orientation.inverse() * s.angular_momentum;
    s.orientation * (body / DVec3::new(across, across, along))
}

fn squirmer_states(system: &System, parts: &Parts) -> Vec<SquirmerState> {
    let mut words = parts.get::<u32>("squirmers");
    words.truncate(system.squirmer_count() as usize * size_of::<SquirmerState>() / 4);
    bytemuck::pod_collect_to_vec(bytemuck::cast_slice::<u32, u8>(&words))
}

/// The centre followed through the periodic boundaries.
fn unwrap(system: &System, s: &SquirmerState) -> DVec3 {
    let period = system.domain.period();
    let mut position = packed::unpack_position(&system.domain, s.position);
    for axis in 0..3 {
        // Across a slit the centre never leaves the box and the image count stays zero.
        position[axis] += f64::from(s.image[axis]) * f64::from(period[axis]);
    }
    position
}

fn totals(words: &[u32], scale: f64) -> Totals {
    if words.len() < 14 {
        return Totals::default();
    }
    let sum = |k: usize| packed::wide(&words[2 * k..]);
    let freedom = sum(6);
    Totals {
        count: sum(0),
        momentum: DVec3::new(sum(1), sum(2), sum(3)) / scale,
        energy: 0.5 * sum(4) / scale,
        temperature: if freedom > 0.0 { sum(5) / scale / freedom } else { 0.0 },
    }
}

/// Bytes as megabytes, for people.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}

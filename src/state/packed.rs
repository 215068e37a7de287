//! Between the host's f64 state and the words that the GPU's buffers hold.

use super::{Domain, Particle, Squirmer, State, System};
use crate::buffers::{SMALLEST_PATCH, Sizes, SpeciesUniform, SquirmerState, SystemUniform, WALL_TILE};
use crate::math::fixed::{Scales, thermal_unit};
use glam::{DQuat, DVec3};

const TURN: f64 = 4_294_967_296.0;

/// A position as u32 fractions of a turn; across a slit it is kept strictly between the walls.
#[must_use]
pub fn pack_position(domain: &Domain, position: DVec3) -> [u32; 3] {
    let period = domain.period();
    let mut words = [0u32; 3];
    for axis in 0..3 {
        let length = f64::from(period[axis]);
        let units = (position[axis] / length * TURN).round();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let word = if axis == 1 && domain.walls.is_some() {
            units.clamp(0.0, 2_147_483_647.0) as u32
        } else {
            units.rem_euclid(TURN) as u32
        };
        words[axis] = word;
    }
    words
}

/// The position that `words` stand for; across a slit a coordinate with the top bit set lies below the low wall.
#[must_use]
pub fn unpack_position(domain: &Domain, words: [u32; 3]) -> DVec3 {
    let period = domain.period();
    let mut position = DVec3::ZERO;
    for axis in 0..3 {
        #[allow(clippy::cast_possible_wrap)]
        let units =
            if axis == 1 && domain.walls.is_some() { f64::from(words[axis] as i32) } else { f64::from(words[axis]) };
        position[axis] = units / TURN * f64::from(period[axis]);
    }
    position
}

#[allow(clippy::cast_possible_truncation)]
fn single(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Particles as the GPU has them: position and the bits of v_x, and v_y with v_z.
#[must_use]
pub fn pack_particles(domain: &Domain, particles: &[Particle]) -> (Vec<[u32; 4]>, Vec<[f32; 2]>) {
    let pack = |p: &Particle| {
        let ([x, y, z], v) = (pack_position(domain, p.position), single(p.velocity));
        ([x, y, z, v[0].to_bits()], [v[1], v[2]])
    };
    particles.iter().map(pack).unzip()
}

/// Particles from three words of position and three of velocity each.
#[must_use]
pub fn unpack_particles(domain: &Domain, positions: &[u32], velocities: &[f32]) -> Vec<Particle> {
    positions
        .chunks_exact(3)
        .zip(velocities.chunks_exact(3))
        .map(|(x, v)| Particle {
            position: unpack_position(domain, [x[0], x[1], x[2]]),
            velocity: double([v[0], v[1], v[2]]),
        })
        .collect()
}

/// Squirmers as the GPU has them.
#[must_use]
pub fn pack_squirmers(system: &System, squirmers: &[Squirmer]) -> Vec<SquirmerState> {
    squirmers
        .iter()
        .map(|s| {
            let position = pack_position(&system.domain, s.position);
            #[allow(clippy::cast_possible_truncation)]
            let orientation = s.orientation.to_array().map(|c| c as f32);
            SquirmerState {
                position,
                species: u32::try_from(s.species).expect("species are few"),
                orientation,
                velocity: single(s.velocity),
                angular_momentum: single(s.angular_momentum),
                position_before: position,
                orientation_before: orientation,
                ..SquirmerState::default()
            }
        })
        .collect()
}

/// The inverse of [`pack_squirmers`].
#[must_use]
pub fn unpack_squirmers(system: &System, states: &[SquirmerState]) -> Vec<Squirmer> {
    states
        .iter()
        .map(|s| Squirmer {
            species: s.species as usize,
            position: unpack_position(&system.domain, s.position),
            orientation: DQuat::from_array(s.orientation.map(f64::from)).normalize(),
            velocity: double(s.velocity),
            angular_momentum: double(s.angular_momentum),
        })
        .collect()
}

/// Species as the GPU has them.
#[must_use]
#[allow(clippy::cast_possible_truncation)]
pub fn pack_species(system: &System) -> Vec<SpeciesUniform> {
    system
        .species
        .iter()
        .map(|s| {
            let ghosts = s.ghosts(&system.fluid);
            let slip = s.hull_slip();
            let (along, across) = s.hull().inertia(f64::from(ghosts));
            SpeciesUniform {
                across: s.semi_axes.across as f32,
                along: s.semi_axes.along as f32,
                b1: slip.b1 as f32,
                b2: slip.b2 as f32,
                rotlet: slip.rotlet as f32,
                mass: ghosts as f32,
                inertia_along: along as f32,
                inertia_across: across as f32,
                ghosts,
                held: u32::from(s.held),
                hull_across: s.hull().across as f32,
                hull_along: s.hull().along as f32,
                force: s.force.map(|c| c as f32),
                vorticity: s.hull().second_mode_vorticity() as f32,
            }
        })
        .collect()
}

/// Units of the wall impulses for a thermal speed of 1 (`shaders/lib/wall-impulse.wgsl`).
const WALL_SCALE: f64 = 1_048_576.0;

/// A 64-bit sum (low word, high word) as f64.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn wide(words: &[u32]) -> f64 {
    ((u64::from(words[1]) << 32) | u64::from(words[0])).cast_signed() as f64
}

/// Momentum that the low and the high wall have received since the start, in m a/tau, from the partial sums of three 64-bit numbers
/// per wall.
#[must_use]
pub fn wall_impulses(system: &System, words: &[u32]) -> [DVec3; 2] {
    let unit = thermal_unit(system.fluid.temperature);
    let mut received = [DVec3::ZERO; 2];
    for partial in words.chunks_exact(12) {
        for (k, pair) in partial.chunks_exact(2).enumerate() {
            received[k / 3][k % 3] += wide(pair) * unit / WALL_SCALE;
        }
    }
    received
}

/// How many elements every extent has.
#[must_use]
pub fn sizes(system: &System, particles: u64) -> Sizes {
    let cells = system.domain.cells();
    let walled = system.domain.walls.is_some();
    let ghosts = system.species.iter().map(|s| s.ghosts(&system.fluid)).max().unwrap_or(0);
    Sizes {
        particles,
        cells: system.domain.cell_count(),
        wall_cells: if walled { 2 * wall_tiles(cells) * u64::from(WALL_TILE).pow(2) } else { 0 },
        wall_patches: if walled { smallest_patches(cells) } else { 0 },
        squirmers: u64::from(system.squirmer_count()),
        species: system.species.len() as u64,
        ghost_stride: u64::from(ghosts.next_multiple_of(64)),
        box_edge: u64::from(box_edge(system)),
        bins: bins(system).iter().map(|n| u64::from(*n)).product(),
        waiting: 0,
        room: 0,
        at_once: false,
        coarse: 0,
        samples: 0,
    }
}

/// Tiles of one wall, for a grid of these cells; those at the end may reach beyond it.
fn wall_tiles(cells: [u32; 3]) -> u64 {
    [cells[0], cells[2]].iter().map(|n| u64::from(n.div_ceil(WALL_TILE))).product()
}

/// Smallest patches of both walls, for a grid of these cells; those at the end may be cut.
#[must_use]
pub fn smallest_patches(cells: [u32; 3]) -> u64 {
    2 * [cells[0], cells[2]].iter().map(|n| u64::from(n.div_ceil(SMALLEST_PATCH))).product::<u64>()
}

/// Largest semi-axis of any hull; 0 without squirmers.
#[must_use]
pub fn longest_semi_axis(system: &System) -> f64 {
    system.species.iter().map(|s| s.hull().radius()).fold(0.0, f64::max)
}

/// Distance from a squirmer within which a particle can meet it in one step: half the longest path of one step.
#[must_use]
pub fn collision_margin(system: &System) -> f64 {
    let speed = Scales::new(system.fluid.density, system.fluid.temperature).max_speed;
    0.5 * speed * system.run.dt
}

/// Cells along the edge of the box around a squirmer that holds every particle near it.
#[must_use]
pub fn box_edge(system: &System) -> u32 {
    if system.species.is_empty() {
        return 0;
    }
    // Half the diagonal of a cell, since cells are judged by their centres, and one cell for the centre's own place in its cell.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let edge = (2.0 * (longest_semi_axis(system) + collision_margin(system) + 0.8661)).ceil() as u32;
    edge + 2
}

/// Squirmers up to which all pairs are looked at: a few positions per invocation cost less than two kernels that fill bins.
pub const FEW_SQUIRMERS: u32 = 1024;

/// Bins per axis of the squirmers' pair search: none narrower than the reach of the steric force; 0 where all pairs are looked at.
#[must_use]
pub fn bins(system: &System) -> [u32; 3] {
    if system.squirmer_count() <= FEW_SQUIRMERS {
        return [0; 3];
    }
    let reach = 2.0 * (longest_semi_axis(system) + STERIC_ALLOWANCE);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    system.domain.size.map(|n| ((f64::from(n) / reach).floor() as u32).clamp(1, 64))
}

/// Room for the safety distance and the range of the steric force, per squirmer, in a.
pub const STERIC_ALLOWANCE: f64 = 1.0;

/// What every kernel knows of the run.
#[must_use]
#[allow(clippy::cast_possible_truncation)]
pub fn system_uniform(system: &System, given: &Sizes) -> SystemUniform {
    let domain = &system.domain;
    let scales = Scales::new(system.fluid.density, system.fluid.temperature);
    let Sizes { particles, room, .. } = *given;
    let sizes = sizes(system, particles);
    let small = |n: u64| u32::try_from(n).expect("extents fit in 32 bits");
    let walls = domain.walls.as_ref();
    let wall = |pick: fn(&super::Walls) -> [f64; 3]| walls.map_or([0.0; 3], pick).map(|c| c as f32);
    SystemUniform {
        size: domain.size,
        walled: u32::from(walls.is_some()),
        cells: domain.cells(),
        slip: u32::from(walls.is_some_and(|w| w.condition == "slip")),
        period: domain.period(),
        cell_count: small(sizes.cells),
        units: domain.period().map(|p| (TURN / f64::from(p)) as f32),
        dt: system.run.dt as f32,
        cell_per_unit: domain.period().map(|p| (f64::from(p) / TURN) as f32),
        particle_count: small(particles),
        acceleration: system.fluid.acceleration.map(|c| c as f32),
        density: system.fluid.density as f32,
        wall_low: wall(|w| w.velocity_low),
        temperature: system.fluid.temperature as f32,
        wall_high: wall(|w| w.velocity_high),
        squirmer_count: system.squirmer_count(),
        seed_low: system.run.seed as u32,
        seed_high: (system.run.seed >> 32) as u32,
        ghost_stride: small(sizes.ghost_stride),
        box_edge: small(sizes.box_edge),
        bins: bins(system),
        max_count: scales.max_count,
        scale_velocity: scales.velocity as f32,
        scale_energy: scales.energy as f32,
        scale_coarse: scales.energy_coarse as f32,
        scale_position: scales.position as f32,
        scale_second: scales.second as f32,
        scale_mixed: scales.mixed as f32,
        max_speed: scales.max_speed as f32,
        thermal_speed: system.fluid.temperature.sqrt() as f32,
        inverse_velocity: (1.0 / scales.velocity) as f32,
        inverse_energy: (1.0 / scales.energy) as f32,
        inverse_coarse: (1.0 / scales.energy_coarse) as f32,
        inverse_position: (1.0 / scales.position) as f32,
        inverse_second: (1.0 / scales.second) as f32,
        inverse_mixed: (1.0 / scales.mixed) as f32,
        room: small(room),
        impulse_unit: thermal_unit(system.fluid.temperature) as f32,
        inverse_impulse_unit: (1.0 / thermal_unit(system.fluid.temperature)) as f32,
        coarse_bit: scales.coarse_bit,
        whole: 12_582_912.0,
        pad: 0,
    }
}

/// Particles that two bricks of 64 cells have room for: eight standard deviations more than the mean of a fluid at rest. A crowd of swimmers compresses the
/// fluid between them, which is as soft as an ideal gas: spheres that fill a quarter of a narrow slit do so by half (`clusters/sphere0` of the
/// validation). Room for that begins where bodies fill 8 % of the box.
#[must_use]
pub fn brick_room(system: &System) -> u64 {
    let bodies = 1.0 - system.fluid_volume() / system.domain.volume();
    with_reserve(128.0 * system.fluid.density * (1.0 + (2.5 * (bodies - 0.08)).clamp(0.0, 0.4)))
}

/// The same for particles at these positions, in coordinate units: more where a crowd of them is more than chance would gather.
#[must_use]
pub fn brick_room_for(system: &System, positions: impl Iterator<Item = [u32; 3]>) -> u64 {
    let mean = 128.0 * system.fluid.density;
    let most = f64::from(largest_crowd(&system.domain, positions));
    // Of 10^8 pairs the fullest has 5.9 standard deviations more than the mean.
    let usual = brick_room(system);
    if most > mean + 7.0 * mean.sqrt() { with_reserve(most).max(usual) } else { usual }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn with_reserve(count: f64) -> u64 {
    let room = (count + 8.0 * count.sqrt()).ceil() as u64 + 16;
    // Whole handfuls of those who wait.
    room.next_multiple_of(Sizes { room, ..Sizes::default() }.handful().max(16))
}

/// Particles in the fullest two bricks that share a room, wherever the grid begins.
fn largest_crowd(domain: &Domain, positions: impl Iterator<Item = [u32; 3]>) -> u32 {
    let lengths = domain.cells().map(|n| n as usize);
    let [nx, ny, nz] = lengths;
    let period = domain.period().map(u64::from);
    let mut counts = vec![0u32; nx * ny * nz];
    for p in positions {
        let cell: [usize; 3] = std::array::from_fn(|k| ((u64::from(p[k]) * period[k]) >> 32) as usize);
        counts[(cell[2] * ny + cell[1].min(ny - 1)) * nx + cell[0]] += 1;
    }
    // Those of the 4 x 4 x 4 cells that begin at each.
    for (length, stride) in [(nx, 1), (ny, nx), (nz, nx * ny)] {
        let before = counts.clone();
        for (i, count) in counts.iter_mut().enumerate() {
            let at = i / stride % length;
            let first = i - at * stride;
            *count = (0..length.min(4)).map(|k| before[first + (at + k) % length * stride]).sum();
        }
    }
    let other = |i: usize, step: &[usize; 3]| {
        let [x, y, z] = [(i % nx, 0), (i / nx % ny, 1), (i / (nx * ny), 2)].map(|(at, k)| (at + step[k]) % lengths[k]);
        counts[(z * ny + y) * nx + x]
    };
    let steps = to_partners(lengths);
    let pairs = (0..counts.len()).flat_map(|i| steps.iter().map(move |step| (i, step)));
    pairs.map(|(i, step)| counts[i] + other(i, step)).max().unwrap_or(0)
}

/// Cells from a brick to the one with which it shares a room, around the box: from an even number to the next, which may be in the next row, or
/// in the next layer of rows.
fn to_partners(lengths: [usize; 3]) -> Vec<[usize; 3]> {
    let [x, y, _] = lengths.map(|n| n.div_ceil(4));
    // Back to the first, which is that far ahead.
    let [back, up, _] = lengths.map(|n| n - 4 * (n.div_ceil(4) - 1));
    let odd = |n: usize| n % 2 == 1;
    [(x > 1, [4, 0, 0]), (odd(x) && y > 1, [back, 4, 0]), (odd(x) && odd(y), [back, up, 4])]
        .into_iter()
        .filter_map(|(there, step)| there.then_some(step))
        .collect()
}

/// The state in the words that the GPU holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Raw {
    /// Steps done.
    pub step: u64,
    /// Three words per particle.
    pub positions: Vec<u32>,
    /// Three words per particle.
    pub velocities: Vec<f32>,
    /// Squirmers.
    pub squirmers: Vec<SquirmerState>,
}

impl Raw {
    /// From the buffers of the GPU.
    #[must_use]
    pub fn new(step: u64, particles: &[[u32; 4]], velocities_yz: &[[f32; 2]], squirmers: Vec<SquirmerState>) -> Self {
        let positions = particles.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        let velocities = particles.iter().zip(velocities_yz).flat_map(|(p, v)| [f32::from_bits(p[3]), v[0], v[1]]);
        Self { step, positions, velocities: velocities.collect(), squirmers }
    }

    /// A 128-bit digest that does not depend on the order of the particles in memory: the hash of the sum of their hashes and of
    /// the squirmers in order.
    #[must_use]
    pub fn digest(&self) -> String {
        let mut sum = 0u128;
        for (x, v) in self.positions.chunks_exact(3).zip(self.velocities.chunks_exact(3)) {
            let mut bytes = [0u8; 24];
            bytes[..12].copy_from_slice(bytemuck::cast_slice(x));
            bytes[12..].copy_from_slice(bytemuck::cast_slice(v));
            let hash = blake3::hash(&bytes);
            sum = sum.wrapping_add(u128::from_le_bytes(hash.as_bytes()[..16].try_into().expect("16 bytes")));
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(&sum.to_le_bytes());
        hasher.update(bytemuck::cast_slice(&self.squirmers));
        hasher.finalize().to_hex()[..32].to_owned()
    }

    /// The same in f64.
    #[must_use]
    pub fn state(&self, system: &System) -> State {
        State {
            step: self.step,
            particles: unpack_particles(&system.domain, &self.positions, &self.velocities),
            squirmers: unpack_squirmers(system, &self.squirmers),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_ignores_order_but_nothing_else() {
        let raw = Raw {
            step: 1,
            positions: vec![1, 2, 3, 4, 5, 6],
            velocities: vec![0.5, 1.0, 1.5, 2.0, 2.5, 3.0],
            squirmers: vec![],
        };
        let swapped =
            Raw { positions: vec![4, 5, 6, 1, 2, 3], velocities: vec![2.0, 2.5, 3.0, 0.5, 1.0, 1.5], ..raw.clone() };
        assert_eq!(raw.digest(), swapped.digest());
        let mixed = Raw { positions: vec![4, 5, 6, 1, 2, 3], ..raw.clone() };
        assert_ne!(raw.digest(), mixed.digest());
        let mut nudged = raw.clone();
        nudged.velocities[3] = f32::from_bits(nudged.velocities[3].to_bits() + 1);
        assert_ne!(raw.digest(), nudged.digest());
    }
}

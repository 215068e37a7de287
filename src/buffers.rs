//! The catalogue of buffers: every name that a shader may bind, what it holds, how long it lives and how large it is.

mod extent;
mod fault;
mod overlay;
mod sizes;

pub use extent::Extent;
pub use fault::{Fault, Site};
pub use overlay::{OVERLAYS, Overlay, lodgers};
pub use sizes::{BRICK_LANES, FEWER_BRICK_LANES, Gathering, Sizes};

use crate::shared;

/// How long a buffer's content means something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Life {
    /// Written once before the run.
    Setting,
    /// State: carried from step to step.
    Persistent,
    /// Computed within a step from the named buffers; stale as soon as one of them is written again, and at the next step.
    Derived(&'static [&'static str]),
    /// Belongs to the stage that uses it.
    Scratch,
}

shared! {
    /// What the kernels of a snapshot are told.
    pub struct MeasureSettings {
        /// Blocks per axis.
        blocks: vec3u,
        /// Cells along the edge of a block.
        edge: u32,
        /// Every how manieth particle is taken.
        stride: u32,
        /// How many particles are taken.
        samples: u32,
        /// Scale of the wide sums.
        scale: f32,
        /// Not used.
        pad: u32,
    }
}

/// Steps for which what does not depend on the state is made at a time.
pub const STEPS_AHEAD: u64 = 63;

/// Cells along the edge of the tiles by which cells at walls are numbered.
pub const WALL_TILE: u32 = 8;

/// Cells along the edge of the smallest patch of a wall.
pub const SMALLEST_PATCH: u32 = 4;

/// One buffer of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct Buffer {
    /// Its name here, in every shader and in drawings.
    pub name: &'static str,
    /// What it holds, with units.
    pub doc: &'static str,
    /// How long its content means something.
    pub life: Life,
    /// What it has one element for.
    pub extent: Extent,
    /// 32-bit words per element.
    pub words: usize,
}

shared! {
    /// What every kernel knows of the run; bound as `system`.
    pub struct SystemUniform {
        /// Box length per axis in cells.
        size: vec3u,
        /// 1 in a slit between walls across y, else 0.
        walled: u32,
        /// Cells per axis of the collision grid.
        cells: vec3u,
        /// 1 if the walls reflect specularly (slip), 0 if they are no-slip.
        slip: u32,
        /// One turn of the u32 coordinate per axis, in cells.
        period: vec3u,
        /// Number of cells.
        cell_count: u32,
        /// Coordinate units per cell, 2^32/period.
        units: vec3f,
        /// Time step h.
        dt: f32,
        /// Cells per coordinate unit, period/2^32.
        cell_per_unit: vec3f,
        /// Number of particles.
        particle_count: u32,
        /// Body acceleration of the fluid.
        acceleration: vec3f,
        /// Mean particles per cell.
        density: f32,
        /// Velocity of the wall at y = 0.
        wall_low: vec3f,
        /// Temperature in kT.
        temperature: f32,
        /// Velocity of the wall at y = L.
        wall_high: vec3f,
        /// Number of squirmers.
        squirmer_count: u32,
        /// Seed, low word.
        seed_low: u32,
        /// Seed, high word.
        seed_high: u32,
        /// Largest number of ghosts in one squirmer, rounded up to a multiple of 64.
        ghost_stride: u32,
        /// Cells along the edge of the largest box around a squirmer.
        box_edge: u32,
        /// Bins per axis of the squirmers' pair search; 0 where all pairs are looked at.
        bins: vec3u,
        /// Contributions per cell up to which the moment sums are safe.
        max_count: u32,
        /// Scale of sum v in the moments.
        scale_velocity: f32,
        /// Scale of sum |v|^2 in the moments.
        scale_energy: f32,
        /// Scale of the coarse copy of sum |v|^2 in the moments.
        scale_coarse: f32,
        /// Scale of sum x in the moments.
        scale_position: f32,
        /// Scale of sum x x^T in the moments.
        scale_second: f32,
        /// Scale of sum x v^T in the moments.
        scale_mixed: f32,
        /// Speed up to which the moment sums are safe.
        max_speed: f32,
        /// sqrt(kT).
        thermal_speed: f32,
        /// 1 / scale_velocity: powers of two have exact reciprocals, but a GPU's own division need not find them.
        inverse_velocity: f32,
        /// 1 / scale_energy.
        inverse_energy: f32,
        /// 1 / scale_coarse.
        inverse_coarse: f32,
        /// 1 / scale_position.
        inverse_position: f32,
        /// 1 / scale_second.
        inverse_second: f32,
        /// 1 / scale_mixed.
        inverse_mixed: f32,
        /// Particles that two bricks of 4 x 4 x 4 cells have room for together.
        room: u32,
        /// Unit of impulses and of ghosts' velocities in fixed point: the power of two next to the thermal speed.
        impulse_unit: f32,
        /// 1 / impulse_unit.
        inverse_impulse_unit: f32,
        /// Bit from which on the coarse copy of sum |v|^2 stands above the count.
        coarse_bit: u32,
        /// 1.5 * 2^23, for rounding: a number that no compiler knows.
        whole: f32,
        /// Not used.
        pad: u32,
    }
}

shared! {
    /// A squirmer's state on the GPU.
    pub struct SquirmerState {
        /// Centre, in coordinate units.
        position: vec3u,
        /// Index into `species`.
        species: u32,
        /// What rounding left of the centre, in coordinate units.
        remainder: vec3f,
        /// Not used.
        pad0: u32,
        /// How often the centre crossed the box, per axis.
        image: vec3i,
        /// Not used.
        pad1: u32,
        /// Quaternion (x, y, z, w) from body axes to lab axes; body z is the axis e.
        orientation: vec4f,
        /// Velocity of the centre.
        velocity: vec3f,
        /// Not used.
        pad2: u32,
        /// Angular momentum about the centre, lab frame.
        angular_momentum: vec3f,
        /// Not used.
        pad3: u32,
        /// Centre at the beginning of the step.
        position_before: vec3u,
        /// Not used.
        pad4: u32,
        /// Orientation at the beginning of the step.
        orientation_before: vec4f,
        /// Mean velocity over the step's motion: the V of the surface velocity.
        drift: vec3f,
        /// Not used.
        pad5: u32,
        /// Mean angular velocity over the step's motion: the Omega of the surface velocity.
        spin: vec3f,
        /// Not used.
        pad6: u32,
    }
}

shared! {
    /// A squirmer species on the GPU.
    pub struct SpeciesUniform {
        /// Semi-axis across e.
        across: f32,
        /// Semi-axis along e.
        along: f32,
        /// Swimming mode B1.
        b1: f32,
        /// Stresslet mode B2 = beta B1.
        b2: f32,
        /// Rotlet dipole C2.
        rotlet: f32,
        /// Mass M = ghosts * m.
        mass: f32,
        /// Moment of inertia about e.
        inertia_along: f32,
        /// Moment of inertia about an axis perpendicular to e.
        inertia_across: f32,
        /// Ghosts inside one squirmer.
        ghosts: u32,
        /// 1 if held in place.
        held: u32,
        /// Semi-axis across e of the surface that the fluid meets.
        hull_across: f32,
        /// Semi-axis along e of the surface that the fluid meets.
        hull_along: f32,
        /// Constant force in the lab frame.
        force: vec3f,
        /// Vorticity of the second mode's flow at the surface, in units of its slip over sqrt(across^2 zeta^2 + along^2 (1 - zeta^2)).
        vorticity: f32,
    }
}

shared! {
    /// What changes from dispatch to dispatch without touching memory; bound as `var<immediate> now`.
    pub struct Now {
        /// Step being done, low word.
        step_low: u32,
        /// Step being done, high word.
        step_high: u32,
        /// Which repetition of the phase, counted from 0.
        repetition: u32,
        /// Not used.
        pad: u32,
    }
}

const fn buffer(name: &'static str, life: Life, extent: Extent, words: usize, doc: &'static str) -> Buffer {
    Buffer { name, doc, life, extent, words }
}

use Extent::{
    Binned, Bins, Blocks, Bricks, Cells, Coarse, Links, One, Particles, Rooms, Samples, Species, SquirmerGhosts,
    Squirmers, Steps, Waiting, WallCells, WallPatches,
};
impl Now {
    /// What a kernel is told of a step and of the repetition of its stage.
    #[must_use]
    #[allow(clippy::cast_possible_truncation)]
    pub fn at(step: u64, repetition: u32) -> Self {
        Self { step_low: step as u32, step_high: (step >> 32) as u32, repetition, pad: 0 }
    }
}

use Life::{Derived, Persistent, Scratch, Setting};

/// Every buffer. `settings` stands for the uniform of the stage that binds it.
pub const CATALOGUE: &[Buffer] = &[
    buffer("system", Setting, One, size_of::<SystemUniform>() / 4, "box, time step, fluid: SystemUniform"),
    buffer("settings", Setting, One, 0, "the stage's own parameters"),
    buffer(
        "species",
        Setting,
        Species,
        size_of::<SpeciesUniform>() / 4,
        "shapes, slip and masses of the squirmer species",
    ),
    buffer(
        "particles",
        Persistent,
        Particles,
        4,
        "particle positions, u32 fractions of the period, and v_x, sqrt(kT/m)",
    ),
    buffer("velocities_yz", Persistent, Particles, 2, "v_y and v_z of the particles, sqrt(kT/m)"),
    buffer(
        "squirmers",
        Persistent,
        Squirmers,
        size_of::<SquirmerState>() / 4,
        "squirmer poses, velocities, angular momenta",
    ),
    buffer("steric", Persistent, Squirmers, 8, "steric force (0..3) and torque (4..7) on each squirmer, kT/a and kT"),
    buffer(
        "fluid_force",
        Persistent,
        Squirmers,
        8,
        "force and torque of the fluid on each squirmer in the last step, kT/a and kT",
    ),
    buffer(
        "impulses",
        Persistent,
        Squirmers,
        12,
        "momentum and angular momentum handed to each squirmer: six wide sums",
    ),
    buffer(
        "wall_impulses",
        Persistent,
        One,
        64 * 12,
        "momentum handed to the low and the high wall since the start: 64 partial sums of six wide sums",
    ),
    buffer(
        "wall_shear",
        Persistent,
        WallPatches,
        6,
        "fluid beside each patch of the walls: averages of sum y (v - u_w) along x and z and of sum y^2, for even steps, then odd ones",
    ),
    buffer(
        "wall_ghosts",
        Derived(&["shift"]),
        WallCells,
        24,
        "fixed-point sums over the ghosts in each cell that a wall cuts, as in `moments`",
    ),
    buffer(
        "wall_seen",
        Derived(&[]),
        WallCells,
        8,
        "of the fluid in the two cells next to the wall: sum y (v - u_w) along x and z and sum y^2, in fixed point",
    ),
    buffer(
        "wall_sums",
        Persistent,
        WallPatches,
        12,
        "the same beside each patch of the walls, three wide sums: of the last even step, then of the last odd one",
    ),
    buffer(
        "faults",
        Persistent,
        One,
        8,
        "what went wrong: flags; where, in which cell, with which particle or squirmer, and in which step first (shaders/lib/fault.wgsl)",
    ),
    buffer("shift", Derived(&[]), One, 4, "grid shift of this step, in coordinate units"),
    buffer("shift_before", Derived(&[]), One, 4, "grid shift of the step before, in coordinate units"),
    buffer(
        "shifts",
        Scratch,
        Steps,
        64,
        "grid shifts of the steps to come and of the one before, 256 bytes apart: in the fused plan `shift` and `shift_before` lie here",
    ),
    buffer(
        "moments",
        Derived(&["particles", "velocities_yz", "shift"]),
        Cells,
        24,
        "fixed-point sums over each cell: 1, v, |v|^2, x, xx, xv",
    ),
    buffer(
        "operators",
        Derived(&["moments"]),
        Cells,
        16,
        "v' = b + A v + W x x of each cell: three rows of A, each with one of W, then b",
    ),
    buffer(
        "ghosts",
        Derived(&[]),
        SquirmerGhosts,
        4,
        "of each ghost: from its squirmer's centre, in cells; v_x beside that of all, random and slip",
    ),
    buffer("ghosts_yz", Derived(&[]), SquirmerGhosts, 2, "v_y and v_z of the same"),
    buffer(
        "ghost_sums",
        Scratch,
        Squirmers,
        31,
        "sums over the ghosts of each squirmer: 15 wide sums, and how many take part",
    ),
    buffer(
        "ghost_motion",
        Derived(&[]),
        Squirmers,
        8,
        "linear (0..3) and angular (4..7) velocity added to each squirmer's ghosts",
    ),
    buffer(
        "squirmer_map",
        Scratch,
        Cells,
        1,
        "squirmers near each cell: their number, and a plane that touches the only one",
    ),
    buffer("squirmer_lists", Scratch, Cells, 7, "up to seven indices of the squirmers near each cell"),
    buffer("steric_sums", Scratch, Squirmers, 8, "sums of steric force, torque, contacts; zero between substeps"),
    buffer("bin_heads", Scratch, Bins, 1, "first squirmer of each bin, index + 1"),
    buffer("bin_next", Scratch, Binned, 1, "next squirmer of the same bin, index + 1"),
    buffer(
        "chains",
        Scratch,
        Cells,
        2,
        "the last particle, then ghost, of each cell, counted from 1, in even steps and in odd ones; zero after the sums over either",
    ),
    buffer(
        "links",
        Scratch,
        Links,
        1,
        "the particle, then ghost, before each in the chain of its cell, counted from 1",
    ),
    buffer(
        "held",
        Scratch,
        Waiting,
        1,
        "the particles that wait for a kernel of their own: their numbers, or where handfuls of a brick lie",
    ),
    buffer(
        "held_groups",
        Scratch,
        One,
        8,
        "of even steps, then of odd ones: workgroups along x, y and z for those who wait, and their number",
    ),
    buffer("bricks_xy", Scratch, Rooms, 2, "x and y of the particles, brick by brick"),
    buffer("bricks_zu", Scratch, Rooms, 2, "z and v_x of the particles, brick by brick"),
    buffer("bricks_vw", Scratch, Rooms, 2, "v_y and v_z of the particles, brick by brick"),
    buffer("brick_counts", Scratch, Bricks, 1, "particles in each brick"),
    buffer(
        "brick_ghosts",
        Scratch,
        Bricks,
        1,
        "ghosts in each brick, where its particles come to lie next; zero after the sums over its cells",
    ),
    buffer("bricks_xy_next", Scratch, Rooms, 2, "x and y once all have moved; the two change places in every step"),
    buffer("bricks_zu_next", Scratch, Rooms, 2, "z and v_x once all have moved"),
    buffer("bricks_vw_next", Scratch, Rooms, 2, "v_y and v_z once all have moved"),
    buffer("particles_next", Scratch, Particles, 4, "positions and v_x, back in one row after an even number of steps"),
    buffer("velocities_yz_next", Scratch, Particles, 2, "v_y and v_z of the same"),
    buffer("brick_counts_next", Scratch, Bricks, 1, "particles in each brick once all have moved, else zero"),
    buffer("brick_total", Scratch, One, 1, "particles that are back in one row"),
    buffer("places", Scratch, Cells, 1, "sorting: particles per cell, then the place of the next"),
    buffer("block_sums", Scratch, Blocks, 1, "sorting: particles per block of cells, then the place of its first"),
    buffer("particles_sorted", Scratch, Particles, 4, "positions and v_x in their new order"),
    buffer("velocities_yz_sorted", Scratch, Particles, 2, "v_y and v_z in their new order"),
    buffer("totals", Scratch, One, 14, "snapshot: seven wide sums over the fluid"),
    buffer("fields", Scratch, Coarse, 4, "snapshot: particles and summed velocity of each block"),
    buffer("samples", Scratch, Samples, 6, "snapshot: positions and velocities of some particles"),
];

/// The buffer of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Buffer> {
    CATALOGUE.iter().find(|b| b.name == name)
}

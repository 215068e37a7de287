//! What is simulated, on the host and in f64: the physical system, and the state of its particles and squirmers.

pub mod packed;
pub mod scene;
pub mod start;
pub mod system;

pub use system::{Domain, Fluid, Init, Run, SemiAxes, Species, System, Walls};

use glam::{DQuat, DVec3};

/// One fluid particle of mass m = 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Particle {
    /// Position in a; in `[0, L)` on every axis.
    pub position: DVec3,
    /// Velocity in sqrt(kT/m).
    pub velocity: DVec3,
}

/// One squirmer: a rigid spheroid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Squirmer {
    /// Index into [`System::species`].
    pub species: usize,
    /// Centre in a; in `[0, L)` on every axis.
    pub position: DVec3,
    /// Turns body axes into lab axes; the body's z axis is its swimming axis e.
    pub orientation: DQuat,
    /// Velocity of the centre in sqrt(kT/m).
    pub velocity: DVec3,
    /// Angular momentum about the centre, lab frame, in a sqrt(m kT).
    pub angular_momentum: DVec3,
}

impl Squirmer {
    /// The swimming axis e, lab frame.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        self.orientation * DVec3::Z
    }
}

/// Positions and velocities of everything at one moment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    /// Steps done.
    pub step: u64,
    /// The fluid.
    pub particles: Vec<Particle>,
    /// The squirmers, species by species in the order of the pipeline file.
    pub squirmers: Vec<Squirmer>,
}

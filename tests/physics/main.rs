//! The physics of whole runs on the adapter: conservation, equilibrium, flow and swimming against theory.
//!
//! Every test has a fixed seed and two sizes: one for an adapter in software, and, with `SQUIRM_PHYSICS=full`, a larger
//! one with tighter tolerances for a GPU.

#[path = "../rig/mod.rs"]
mod rig;

mod conservation;
mod couette;
mod density;
mod exclusion;
mod poiseuille;
mod swimming;
mod temperature;
mod viscosity;

use glam::{DQuat, DVec3};
use squirm::gpu::Session;
use squirm::state::{Particle, Species, State, System};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The first, or the second with `SQUIRM_PHYSICS=full`.
fn size<T>(quick: T, full: T) -> T {
    if std::env::var("SQUIRM_PHYSICS").is_ok_and(|v| v == "full") { full } else { quick }
}

/// The tests share one device: one at a time.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Every stage of squirmers in a periodic box.
const SQUIRMERS: &[&str] = &[
    "squirmer-move",
    "stream",
    "squirmer-collide",
    "shift-grid",
    "sort-reorder",
    "cell-reduce",
    "squirmer-fill",
    "rotate",
    "restore-thermostat",
    "apply",
];

/// Does `steps` steps, in submissions that are short enough for a driver's watchdog.
fn advance(session: &mut Session, steps: u64) {
    let mut left = steps;
    while left > 0 {
        let now = left.min(100);
        session.advance(now, false);
        session.wait().expect("the device answers");
        left -= now;
    }
}

/// No kernel has met anything that it could not handle.
fn sound(session: &Session) {
    assert_eq!(session.faults().expect("faults are readable"), 0);
}

/// The squirmers' mass is that of their ghosts.
fn mass(system: &System, species: usize) -> f64 {
    f64::from(system.species[species].ghosts(&system.fluid))
}

/// Momentum of the fluid and of all squirmers.
fn momentum(system: &System, state: &State) -> DVec3 {
    let fluid: DVec3 = state.particles.iter().map(|p| p.velocity).sum();
    fluid + state.squirmers.iter().map(|s| mass(system, s.species) * s.velocity).sum::<DVec3>()
}

/// A species of listed squirmers.
fn listed(species: Species, poses: Vec<[f64; 6]>) -> Species {
    let count = u32::try_from(poses.len()).expect("few squirmers");
    Species { count, start: "listed".into(), poses: Some(poses), ..species }
}

/// How far a point is from the centre of a spheroid, in units of its surface: |S r'|.
fn scaled_radius(system: &System, species: usize, orientation: DQuat, arm: DVec3) -> f64 {
    let axes = system.species[species].semi_axes.clone();
    ((orientation.inverse() * arm) / DVec3::new(axes.across, axes.across, axes.along)).length()
}

/// Kinetic energy of the fluid per degree of freedom, in kT/2.
fn temperature<'a>(particles: impl Iterator<Item = &'a Particle>) -> f64 {
    let (sum, count) = particles.fold((0.0, 0.0), |(s, n), p| (s + p.velocity.length_squared(), n + 1.0));
    sum / (3.0 * count)
}

//! The start of a run, on the host and in f64: a function of the system and its seed.

mod crowd;
mod fluid;
mod image;
mod place;
mod stream;
mod table;

pub use image::{nearest_image, wrap};
pub use place::{SURE, check, crowding, poses};
pub use table::{from_csv, speed_problem};

use super::{Particle, Squirmer, State, System};
use glam::{DQuat, DVec3};
use stream::{Stream, Use};

/// Why a run cannot start.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StartError {
    /// A body is larger than the box.
    #[error("a squirmer of species `{species}` needs more than {needed:.2} a along {axis}, but the box has {length} a")]
    Narrow {
        /// Species.
        species: String,
        /// Axis of the box.
        axis: &'static str,
        /// What the body needs.
        needed: f64,
        /// What there is.
        length: f64,
    },
    /// No arrangement without overlap was found.
    #[error("{count} squirmers, {:.1} % of the box, could not be placed without overlap", 100.0 * share)]
    Crowded {
        /// Squirmers.
        count: usize,
        /// Their share of the volume.
        share: f64,
    },
    /// A lattice has too few sites.
    #[error("a lattice with axes along x has no room for {count} squirmers of species `{species}`")]
    Lattice {
        /// Species.
        species: String,
        /// Squirmers.
        count: usize,
    },
    /// The wrong number of listed poses.
    #[error("species `{species}` has count = {wanted}, but {found} poses are listed")]
    Poses {
        /// Species.
        species: String,
        /// Rows found.
        found: usize,
        /// Rows needed.
        wanted: u32,
    },
    /// A listed direction is zero.
    #[error("row {row} of the poses of species `{species}` has no direction: (ex, ey, ez) is zero")]
    NoDirection {
        /// Species.
        species: String,
        /// Row, counted from 1.
        row: usize,
    },
    /// A listed squirmer reaches into a wall.
    #[error("squirmer {squirmer} of species `{species}` at y = {y} reaches into a wall")]
    InWall {
        /// Squirmer, counted from 0 over all species.
        squirmer: usize,
        /// Species.
        species: String,
        /// Its centre.
        y: f64,
    },
    /// Two squirmers overlap.
    #[error("squirmers {first} and {second} overlap (counted from 0 over all species)")]
    Overlap {
        /// One.
        first: usize,
        /// The other.
        second: usize,
    },
    /// No place for the fluid.
    #[error("squirmers fill the box: no place was found for a fluid particle")]
    NoFluid,
    /// A table of particles is not usable.
    #[error("{path}, line {line}: {reason}")]
    Table {
        /// File.
        path: String,
        /// Line, counted from 1; 0 if the file could not be opened.
        line: u64,
        /// What is wrong.
        reason: String,
    },
}

/// The state at step 0. Squirmers do not overlap, steric margins included where they are placed at random. Velocities are those of
/// thermal equilibrium, less the mean motion: fluid and free squirmers together have no momentum. Particles that come from a
/// table keep their velocities.
///
/// # Errors
/// If squirmers or fluid find no place, or the table of particles is not usable.
pub fn start(system: &System) -> Result<State, StartError> {
    let poses = place::poses(system)?;
    let mut squirmers: Vec<Squirmer> =
        system.squirmer_species().zip(poses).enumerate().map(|(i, (s, pose))| thermal(system, i, s, pose)).collect();
    let particles = if let Some(path) = &system.init.from {
        from_csv(path.as_ref(), system, &squirmers)?
    } else {
        let mut particles = fluid::fluid(system, &squirmers).ok_or(StartError::NoFluid)?;
        stop(system, &mut particles, &mut squirmers);
        particles
    };
    Ok(State { step: 0, particles, squirmers })
}

/// A squirmer with velocity and angular momentum of Maxwell and Boltzmann; one that is held has neither.
fn thermal(system: &System, index: usize, species: usize, (position, orientation): (DVec3, DQuat)) -> Squirmer {
    let kind = &system.species[species];
    let (mut velocity, mut angular_momentum) = (DVec3::ZERO, DVec3::ZERO);
    if !kind.held {
        let mass = f64::from(kind.ghosts(&system.fluid));
        let (along, across) = kind.hull().inertia(mass);
        #[allow(clippy::cast_possible_truncation)]
        let mut stream = Stream::new(system.run.seed, Use::Motion, index as u32);
        let thermal = system.fluid.temperature.sqrt();
        velocity = thermal / mass.sqrt() * stream.normals();
        angular_momentum = orientation * (thermal * DVec3::new(across, across, along).powf(0.5) * stream.normals());
    }
    Squirmer { species, position, orientation, velocity, angular_momentum }
}

/// Total momentum and mass of everything that moves.
fn momentum(system: &System, particles: &[Particle], squirmers: &[Squirmer]) -> (DVec3, f64) {
    let fluid: DVec3 = particles.iter().map(|p| p.velocity).sum();
    let mut total = (fluid, particles.len() as f64);
    for squirmer in squirmers {
        let kind = &system.species[squirmer.species];
        if !kind.held {
            let mass = f64::from(kind.ghosts(&system.fluid));
            total = (total.0 + mass * squirmer.velocity, total.1 + mass);
        }
    }
    total
}

/// Takes the motion of the centre of mass off; twice, since the first time rounding leaves a little.
fn stop(system: &System, particles: &mut [Particle], squirmers: &mut [Squirmer]) {
    for _ in 0..2 {
        let (total, mass) = momentum(system, particles, squirmers);
        if mass > 0.0 {
            let mean = total / mass;
            particles.iter_mut().for_each(|p| p.velocity -= mean);
            squirmers.iter_mut().filter(|s| !system.species[s.species].held).for_each(|s| s.velocity -= mean);
        }
    }
}

#[cfg(test)]
mod tests;

//! The `particles` message: a share of the fluid particles.

use super::encode::message_bytes;
use super::{Encoder, Kind, Snapshot, Stamp, WireError};

/// Fluid particles of mass m = 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Particles {
    /// Share of the particles that was asked for.
    pub fraction: f64,
    /// Particles in the fluid.
    pub population: u64,
    /// Positions in a; in `[0, L)`.
    pub position: Vec<[f32; 3]>,
    /// Velocities in sqrt(kT/m).
    pub velocity: Vec<[f32; 3]>,
}

impl Particles {
    /// Length of the message of `n` particles.
    #[must_use]
    pub fn message_bytes(n: usize) -> usize {
        message_bytes(&[12, 12].map(|width| (width, n)))
    }

    /// The message.
    #[must_use]
    pub fn encode(&self, stamp: &Stamp) -> Vec<u8> {
        let mut encoder = Encoder::new(Kind::Particles, stamp).rows(self.position.len(), self.population);
        encoder.header_mut().fraction = self.fraction;
        encoder.column("position", "a", &self.position).column("velocity", "sqrt(kT/m)", &self.velocity).finish()
    }

    /// The particles of a message.
    ///
    /// # Errors
    /// If it is a message of another kind, or its columns have different lengths.
    pub fn decode(snapshot: &Snapshot<'_>) -> Result<Self, WireError> {
        snapshot.expect(Kind::Particles)?;
        let (position, velocity) = (snapshot.rows::<f32, 3>("position")?, snapshot.rows::<f32, 3>("velocity")?);
        if position.len() != velocity.len() {
            return Err(WireError::Malformed("the particles' columns have different lengths".into()));
        }
        let header = &snapshot.header;
        Ok(Self { fraction: header.fraction, population: header.population, position, velocity })
    }

    /// Whether every particle of the fluid is here.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.position.len() as u64 == self.population
    }
}

//! The `particles` message: a share of the fluid particles.

use super::encode::message_bytes;
use super::{Encoder, Kind, Snapshot, Stamp, WireError};

/// Name of the column that only complete messages have.
const REST: &str = "position_rest";

/// Fluid particles of mass m = 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Particles {
    /// Share of the particles that was asked for.
    pub fraction: f64,
    /// Particles in the fluid.
    pub population: u64,
    /// Positions in a; in `[0, L)`.
    pub position: Vec<[f32; 3]>,
    /// What rounding to f32 took from the positions, if every particle is here, so that the state can be given back; else empty.
    pub rest: Vec<[f32; 3]>,
    /// Velocities in sqrt(kT/m).
    pub velocity: Vec<[f32; 3]>,
}

impl Particles {
    /// Length of the message of `n` particles, all there are or a share.
    #[must_use]
    pub fn message_bytes(n: usize, all: bool) -> usize {
        let columns = [12, 12, 12].map(|width| (width, n));
        message_bytes(if all { &columns } else { &columns[..2] })
    }

    /// Appends one particle; with `exact`, its position can be given back to the last bit.
    #[allow(clippy::cast_possible_truncation)]
    pub fn push(&mut self, position: [f64; 3], velocity: [f32; 3], lengths: [f64; 3], exact: bool) {
        let rounded: [f32; 3] = std::array::from_fn(|k| {
            let single = position[k] as f32;
            // Rounding up must not carry a particle out of the box.
            if f64::from(single) < lengths[k] { single } else { single.next_down() }
        });
        if exact {
            self.rest.push(std::array::from_fn(|k| (position[k] - f64::from(rounded[k])) as f32));
        }
        self.position.push(rounded);
        self.velocity.push(velocity);
    }

    /// The position of particle `i` as exactly as the message has it.
    #[must_use]
    pub fn place(&self, i: usize) -> [f64; 3] {
        let rest = self.rest.get(i).copied().unwrap_or_default();
        std::array::from_fn(|k| f64::from(self.position[i][k]) + f64::from(rest[k]))
    }

    /// The message.
    #[must_use]
    pub fn encode(&self, stamp: &Stamp) -> Vec<u8> {
        let mut encoder = Encoder::new(Kind::Particles, stamp).rows(self.position.len(), self.population);
        encoder.header_mut().fraction = self.fraction;
        encoder = encoder.column("position", "a", &self.position).column("velocity", "sqrt(kT/m)", &self.velocity);
        if !self.rest.is_empty() {
            encoder = encoder.column(REST, "a", &self.rest);
        }
        encoder.finish()
    }

    /// The particles of a message.
    ///
    /// # Errors
    /// If it is a message of another kind, or its columns have different lengths.
    pub fn decode(snapshot: &Snapshot<'_>) -> Result<Self, WireError> {
        snapshot.expect(Kind::Particles)?;
        let (position, velocity) = (snapshot.rows::<f32, 3>("position")?, snapshot.rows::<f32, 3>("velocity")?);
        let rest = match snapshot.rows::<f32, 3>(REST) {
            Err(WireError::NoColumn { .. }) => Vec::new(),
            rest => rest?,
        };
        if position.len() != velocity.len() || !(rest.is_empty() || rest.len() == position.len()) {
            return Err(WireError::Malformed("the particles' columns have different lengths".into()));
        }
        let header = &snapshot.header;
        Ok(Self { fraction: header.fraction, population: header.population, position, rest, velocity })
    }

    /// Whether every particle of the fluid is here.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.position.len() as u64 == self.population
    }
}

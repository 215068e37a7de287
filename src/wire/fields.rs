//! The `fields` message: the fluid averaged over blocks of cells.

use super::encode::message_bytes;
use super::{Encoder, Kind, Snapshot, Stamp, WireError};

/// Fields on a grid of blocks, x fastest: index = (z * ny + y) * nx + x.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fields {
    /// Edge of a block in a.
    pub block: u32,
    /// Blocks along x, y and z.
    pub blocks: [u32; 3],
    /// Mass density in m/a^3.
    pub density: Vec<f32>,
    /// Mean velocity in sqrt(kT/m); zero where the block is empty.
    pub velocity: Vec<[f32; 3]>,
}

impl Fields {
    /// Length of the message of `n` blocks.
    #[must_use]
    pub fn message_bytes(n: usize) -> usize {
        message_bytes(&[4, 12].map(|width| (width, n)))
    }

    /// The message.
    #[must_use]
    pub fn encode(&self, stamp: &Stamp) -> Vec<u8> {
        let mut encoder = Encoder::new(Kind::Fields, stamp).rows(self.density.len(), self.density.len() as u64);
        encoder.header_mut().block = self.block;
        encoder.header_mut().blocks = self.blocks;
        encoder.flat("density", "m/a^3", 1, &self.density).column("velocity", "sqrt(kT/m)", &self.velocity).finish()
    }

    /// The fields of a message.
    ///
    /// # Errors
    /// If it is a message of another kind, or its columns do not have the grid's size.
    pub fn decode(snapshot: &Snapshot<'_>) -> Result<Self, WireError> {
        snapshot.expect(Kind::Fields)?;
        let blocks = snapshot.header.blocks;
        let (density, velocity) = (snapshot.values::<f32>("density")?, snapshot.rows::<f32, 3>("velocity")?);
        let count = blocks.iter().try_fold(1usize, |n, b| n.checked_mul(*b as usize));
        if count != Some(density.len()) || density.len() != velocity.len() {
            return Err(WireError::Malformed(format!("{} values on a grid of {blocks:?} blocks", density.len())));
        }
        Ok(Self { block: snapshot.header.block, blocks, density, velocity })
    }
}

//! Random numbers of the start: one stream for each purpose and owner, so that adding a squirmer changes no other's numbers.

use crate::math::draws::normals;
use crate::math::rng::{Draw, Purpose};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// What a stream is for.
#[derive(Debug, Clone, Copy)]
#[repr(u32)]
pub enum Use {
    /// Where a particle is.
    Position,
    /// How a particle moves.
    Velocity,
    /// Where a squirmer is tried.
    Pose,
    /// How a squirmer moves.
    Motion,
}

/// A sequence of random numbers.
#[derive(Debug, Clone)]
pub struct Stream {
    draw: Draw,
    purpose: Use,
    index: u32,
    block: u32,
}

impl Stream {
    /// The numbers of the particle or squirmer `index`.
    #[must_use]
    pub fn new(seed: u64, purpose: Use, index: u32) -> Self {
        Self { draw: Draw::new(seed, Purpose::Start, 0), purpose, index, block: 0 }
    }

    /// The next four numbers, uniform in (0, 1), with 32 bits each.
    pub fn uniforms(&mut self) -> [f64; 4] {
        let words = self.draw.words(self.purpose as u32, self.index, self.block);
        self.block += 1;
        words.map(|w| (f64::from(w) + 0.5) / 2f64.powi(32))
    }

    /// Three normal numbers of unit variance.
    pub fn normals(&mut self) -> DVec3 {
        normals(self.uniforms())
    }

    /// A rotation that takes z to `e`, otherwise random.
    pub fn orientation(&mut self, e: DVec3) -> DQuat {
        DQuat::from_rotation_arc(DVec3::Z, e) * DQuat::from_rotation_z(TAU * self.uniforms()[0])
    }
}

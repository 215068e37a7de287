//! What is read off the fluid: sums over its particles, as the GPU holds them.

use crate::case::Trouble;
use glam::{DVec3, Vec3Swizzles};
use squirm::gpu::Session;
use squirm::state::{Domain, packed};

/// The fluid's particles at one moment.
pub struct Fluid {
    positions: Vec<u32>,
    velocities: Vec<f32>,
    domain: Domain,
}

impl Fluid {
    /// Reads the particles; waits for the GPU.
    pub fn of(session: &Session) -> Result<Self, Trouble> {
        let raw = session.raw()?;
        Ok(Self { positions: raw.positions, velocities: raw.velocities, domain: session.system().domain.clone() })
    }

    /// Positions in a and velocities.
    pub fn particles(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        self.positions.chunks_exact(3).zip(self.velocities.chunks_exact(3)).map(|(x, v)| {
            let velocity = DVec3::new(v[0].into(), v[1].into(), v[2].into());
            (packed::unpack_position(&self.domain, [x[0], x[1], x[2]]), velocity)
        })
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len() / 3
    }

    /// Total momentum, sqrt(m kT).
    pub fn momentum(&self) -> DVec3 {
        let sum = |v: &[f32]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
        self.velocities.chunks_exact(3).map(sum).sum()
    }

    /// Amplitudes of the six waves of the Beltrami flow of wave number k: v_x ~ sin kz, v_y ~ sin kx, v_z ~ sin ky and v_x ~ cos ky,
    /// v_y ~ cos kz, v_z ~ cos kx.
    pub fn beltrami(&self, k: f64) -> [f64; 6] {
        let (mut sines, mut cosines) = (DVec3::ZERO, DVec3::ZERO);
        for (r, v) in self.particles() {
            sines += v * (k * r).map(f64::sin).zxy();
            cosines += v * (k * r).map(f64::cos).yzx();
        }
        let scale = 2.0 / self.len() as f64;
        let (s, c) = (scale * sines, scale * cosines);
        [s.x, s.y, s.z, c.x, c.y, c.z]
    }
}

/// Momentum that each of the two walls has received since the start, sqrt(m kT): 64 partial sums of six wide sums in units of 2^-20.
pub fn wall_impulses(session: &Session) -> Result<[DVec3; 2], Trouble> {
    let words = session.read::<u32>("wall_impulses")?;
    let mut out = [DVec3::ZERO; 2];
    for partial in words.chunks_exact(12) {
        for (k, pair) in partial.chunks_exact(2).enumerate() {
            let value = ((u64::from(pair[1]) << 32) | u64::from(pair[0])).cast_signed();
            out[k / 3][k % 3] += value as f64 / 1_048_576.0;
        }
    }
    Ok(out)
}

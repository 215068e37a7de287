//! What is read off the fluid: sums over its particles, as the GPU holds them.

use crate::case::{Row, Trouble};
use glam::DVec3;
use squirm::analyze::statistics::{Estimate, blocked, mean};
use squirm::gpu::Session;
use squirm::state::{Domain, State, packed};

/// The fluid's particles at one moment.
pub struct Fluid {
    positions: Vec<u32>,
    velocities: Vec<f32>,
    domain: Domain,
}

/// Sums over the particles between two heights.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slice {
    /// Particles.
    pub count: f64,
    /// Sum of their velocities, sqrt(kT/m).
    pub velocity: DVec3,
}

impl Fluid {
    /// Reads the particles; waits for the GPU.
    pub fn of(session: &Session) -> Result<Self, Trouble> {
        let raw = session.raw()?;
        Ok(Self { positions: raw.positions, velocities: raw.velocities, domain: session.system().domain.clone() })
    }

    /// Positions in a and velocities.
    pub fn particles(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        self.positions
            .chunks_exact(3)
            .zip(self.velocities())
            .map(|(x, velocity)| (packed::unpack_position(&self.domain, [x[0], x[1], x[2]]), velocity))
    }

    /// Velocities in sqrt(kT/m).
    pub fn velocities(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.velocities.chunks_exact(3).map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into()))
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len() / 3
    }

    /// Total momentum, sqrt(m kT).
    pub fn momentum(&self) -> DVec3 {
        self.velocities().sum()
    }

    /// Kinetic energy, kT.
    pub fn energy(&self) -> f64 {
        self.velocities().map(|v| 0.5 * v.length_squared()).sum()
    }

    /// Kinetic energy per degree of freedom in kT/2; the centre of mass at rest has none.
    pub fn temperature(&self) -> f64 {
        2.0 * self.energy() / (3.0 * (self.len() as f64 - 1.0))
    }

    /// Mean of the fourth power of a velocity component over the square of the mean of its square; 3 for a Gaussian.
    pub fn kurtosis(&self) -> f64 {
        let (mut second, mut fourth) = (DVec3::ZERO, DVec3::ZERO);
        for v in self.velocities() {
            second += v * v;
            fourth += v * v * v * v;
        }
        (fourth / (second * second)).element_sum() / 3.0 * self.len() as f64
    }

    /// Sums over `bins` slices of equal thickness between two walls.
    pub fn slices(&self, bins: usize) -> Vec<Slice> {
        let mut slices = vec![Slice::default(); bins];
        for (x, v) in self.positions.chunks_exact(3).zip(self.velocities()) {
            // Between walls half a turn of the coordinate is the height of the slit.
            let bin = (u64::from(x[1]) * bins as u64) >> 31;
            let slice = &mut slices[(bin as usize).min(bins - 1)];
            slice.count += 1.0;
            slice.velocity += v;
        }
        slices
    }

    /// Particles in each cell of the unshifted unit lattice.
    pub fn occupancy(&self) -> Vec<u32> {
        let [nx, ny, nz] = self.domain.size;
        let mut counts = vec![0; (nx * ny * nz) as usize];
        let period = self.domain.period();
        let index = |x: u32, axis: usize| ((u64::from(x) * u64::from(period[axis])) >> 32) as u32;
        for x in self.positions.chunks_exact(3) {
            counts[((index(x[2], 2) * ny + index(x[1], 1)) * nx + index(x[0], 0)) as usize] += 1;
        }
        counts
    }

    /// Amplitude of the transverse wave v = A p sin(k.r) with the unit vector p.
    pub fn wave(&self, k: DVec3, p: DVec3) -> f64 {
        let sum: f64 = self.particles().map(|(r, v)| p.dot(v) * k.dot(r).sin()).sum();
        2.0 * sum / self.len() as f64
    }

    /// Amplitudes of the waves v_x ~ sin kz and v_y ~ cos kz.
    pub fn helix(&self, k: f64) -> [f64; 2] {
        let (mut x, mut y) = (0.0, 0.0);
        for (r, v) in self.particles() {
            let (sine, cosine) = (k * r.z).sin_cos();
            x += v.x * sine;
            y += v.y * cosine;
        }
        let scale = 2.0 / self.len() as f64;
        [scale * x, scale * y]
    }
}

/// Momentum that the low and the high wall have received since the start, sqrt(m kT).
pub fn wall_impulses(session: &Session) -> Result<[DVec3; 2], Trouble> {
    Ok(packed::wall_impulses(session.system(), &session.read("wall_impulses")?))
}

/// Scales the velocities of a start at rest to exactly this temperature in kT: a rule that keeps the energy keeps what the draw of
/// the start happened to have.
pub fn temper(state: &mut State, temperature: f64) {
    let squares: f64 = state.particles.iter().map(|p| p.velocity.length_squared()).sum();
    let factor = (3.0 * (state.particles.len() as f64 - 1.0) * temperature / squares).sqrt();
    state.particles.iter_mut().for_each(|p| p.velocity *= factor);
}

/// A function of the means of several correlated series that were taken together; its error from the series that the function's
/// derivatives at the means make of them.
pub fn of_means<const N: usize>(frames: &[[f64; N]], function: impl Fn(&[f64; N]) -> f64) -> Estimate {
    let means: [f64; N] = std::array::from_fn(|k| mean(&frames.iter().map(|f| f[k]).collect::<Vec<_>>()));
    let spread =
        |k: usize| (frames.iter().map(|f| (f[k] - means[k]).powi(2)).sum::<f64>() / frames.len() as f64).sqrt();
    let derivatives: [f64; N] = std::array::from_fn(|k| {
        // The means are known to a fraction of the spread: the function is nearly linear over it.
        let step = 0.01 * spread(k);
        if step == 0.0 {
            return 0.0;
        }
        let (mut above, mut below) = (means, means);
        above[k] += step;
        below[k] -= step;
        (function(&above) - function(&below)) / (2.0 * step)
    });
    let linear: Vec<f64> =
        frames.iter().map(|f| (0..N).map(|k| derivatives[k] * (f[k] - means[k])).sum::<f64>()).collect();
    Estimate { mean: function(&means), error: blocked(&linear).error }
}

/// A line of the report.
pub fn row(
    (quantity, setup): (&str, &str),
    found: Estimate,
    (expected, tolerance): (Option<f64>, f64),
    source: &str,
) -> Row {
    Row {
        quantity: quantity.into(),
        setup: setup.into(),
        measured: found.mean,
        error: found.error,
        expected,
        tolerance,
        source: source.into(),
        note: String::new(),
    }
}

/// A figure that is counted, not estimated.
pub fn counted(value: f64) -> Estimate {
    Estimate { mean: value, error: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use squirm::math::rng::{Draw, Purpose};

    /// 4096 pairs of independent normals of means 2 and 4 and variance 1: the quotient of the means is 0.5, and its error is
    /// sqrt(1 + 0.25)/(4 sqrt(4096)) = 0.00437. Blocking scatters by some ten per cent.
    #[test]
    fn the_error_of_a_quotient_is_that_of_its_linear_part() {
        let draw = Draw::new(1, Purpose::Start, 0);
        let normals = |i: u32| {
            let [a, b, ..] = draw.uniforms(i, 0, 0);
            let (sine, cosine) = (std::f64::consts::TAU * b).sin_cos();
            [(-2.0 * a.ln()).sqrt() * cosine, (-2.0 * a.ln()).sqrt() * sine]
        };
        let frames: Vec<[f64; 2]> = (0..4096).map(|i| [2.0 + normals(i)[0], 4.0 + normals(i)[1]]).collect();
        let found = of_means(&frames, |[a, b]| a / b);
        assert!((found.mean - 0.5).abs() < 5.0 * 0.00437, "{found:?}");
        assert!((found.error / 0.00437 - 1.0).abs() < 0.35, "{found:?}");
    }
}

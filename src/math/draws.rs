//! Random variates from the counter-based generator: normal, on the unit sphere, gamma, Poisson.

use super::rng::Draw;
use glam::DVec3;
use std::f64::consts::TAU;

/// Three independent standard normals from four uniforms (Box and Muller, Ann. Math. Stat. 29, 610, 1958).
#[must_use]
pub fn normals(u: [f64; 4]) -> DVec3 {
    let [first, second] = [(-2.0 * u[0].ln()).sqrt(), (-2.0 * u[2].ln()).sqrt()];
    let (sin, cos) = (TAU * u[1]).sin_cos();
    DVec3::new(first * cos, first * sin, second * (TAU * u[3]).cos())
}

/// A direction uniform on the unit sphere: by Archimedes' theorem its z is uniform in (-1, 1).
#[must_use]
pub fn direction(u0: f64, u1: f64) -> DVec3 {
    let z = 2.0 * u0 - 1.0;
    let (sin, cos) = (TAU * u1).sin_cos();
    let rho = (1.0 - z * z).sqrt();
    DVec3::new(rho * cos, rho * sin, z)
}

/// A gamma variate of unit scale: half a squared normal for shape 1/2, else the rejection method of Marsaglia and Tsang,
/// ACM Trans. Math. Softw. 26, 363 (2000), for shapes of at least 1. Attempt i takes three uniforms, `attempt(i)`.
///
/// # Panics
/// If `shape` is neither 1/2 nor at least 1.
#[must_use]
pub fn gamma(shape: f64, attempt: impl Fn(u32) -> [f64; 3]) -> f64 {
    let attempt = |i| {
        let [a, b, u] = attempt(i);
        (normals([a, b, 0.5, 0.0]).x, u)
    };
    if (shape - 0.5).abs() < 1e-9 {
        let (x, _) = attempt(0);
        return x * x / 2.0;
    }
    assert!(shape >= 1.0, "gamma variates of shape {shape} are not provided");
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    let mut i = 0;
    loop {
        let (x, u) = attempt(i);
        let v = (1.0 + c * x).powi(3);
        if v > 0.0 && u.ln() < x * x / 2.0 + d - d * v + d * v.ln() {
            return d * v;
        }
        i += 1;
    }
}

/// How many points a Poisson process of unit rate has on `[0, length)`: four distances from one point to the next take an index of `owner`.
#[must_use]
pub fn poisson(draw: Draw, owner: u32, length: f64) -> u32 {
    let mut distances = (0u32..).flat_map(|i| draw.uniforms(owner, i, 1)).map(|u| -u.ln());
    let mut place = 0.0;
    let mut count = 0;
    loop {
        place += distances.next().expect("there is always another");
        if place >= length {
            return count;
        }
        count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Purpose;

    /// Asserts that the mean of `samples` is `mean` within five standard errors, the variance being `variance`.
    fn assert_mean(samples: impl Iterator<Item = f64>, mean: f64, variance: f64) {
        let (sum, count) = samples.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
        let found: f64 = sum / count;
        assert!((found - mean).abs() < 5.0 * (variance / count).sqrt(), "{found} instead of {mean}");
    }

    fn draw() -> Draw {
        Draw::new(11, Purpose::Start, 5)
    }

    #[test]
    fn normals_have_their_first_four_moments_and_no_correlation() {
        let samples: Vec<DVec3> = (0..40_000).map(|i| normals(draw().uniforms(0, i, 0))).collect();
        for axis in 0..3 {
            let x = || samples.iter().map(|n| n[axis]);
            assert_mean(x(), 0.0, 1.0);
            assert_mean(x().map(|x| x * x), 1.0, 2.0);
            assert_mean(x().map(|x| x.powi(4)), 3.0, 96.0);
            assert_mean(samples.iter().map(|n| n[axis] * n[(axis + 1) % 3]), 0.0, 1.0);
        }
    }

    #[test]
    fn directions_are_isotropic_unit_vectors() {
        let samples: Vec<DVec3> = (0..40_000)
            .map(|i| {
                let u = draw().uniforms(1, i, 0);
                direction(u[0], u[1])
            })
            .collect();
        assert!(samples.iter().all(|e| (e.length() - 1.0).abs() < 1e-12));
        for axis in 0..3 {
            assert_mean(samples.iter().map(|e| e[axis]), 0.0, 1.0 / 3.0);
            assert_mean(samples.iter().map(|e| e[axis].powi(2)), 1.0 / 3.0, 4.0 / 45.0);
            assert_mean(samples.iter().map(|e| e[axis] * e[(axis + 1) % 3]), 0.0, 1.0 / 15.0);
        }
    }

    #[test]
    fn gamma_variates_have_mean_and_variance_equal_to_their_shape() {
        for shape in [0.5, 1.0, 1.5, 3.0, 12.0, 87.0] {
            let samples: Vec<f64> = (0..40_000)
                .map(|owner| {
                    gamma(shape, |i| draw().uniforms(owner, i, 0).first_chunk().copied().expect("four of them"))
                })
                .collect();
            assert!(samples.iter().all(|x| *x >= 0.0));
            assert_mean(samples.iter().copied(), shape, shape);
            // The fourth central moment is 3 k^2 + 6 k.
            assert_mean(samples.iter().map(|x| (x - shape).powi(2)), shape, 2.0 * shape * shape + 6.0 * shape);
        }
    }

    #[test]
    fn counts_are_poisson_distributed() {
        for length in [0.01, 0.7, 10.0, 60.0] {
            let counts: Vec<f64> = (0..20_000).map(|owner| f64::from(poisson(draw(), owner, length))).collect();
            assert_mean(counts.iter().copied(), length, length);
            // The fourth central moment is length + 3 length^2.
            let variance_of_square = length + 2.0 * length * length;
            assert_mean(counts.iter().map(|n| (n - length).powi(2)), length, variance_of_square);
        }
        assert_eq!(poisson(draw(), 3, 0.0), 0);
    }
}

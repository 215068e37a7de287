//! What other free bodies in the fluid take off a body's diffusion, and how long the fluid needs for it.

use squirm::state::start::nearest_image;
use squirm::state::{Squirmer, System};

/// Width of a bin of distances, in a.
const BIN: f64 = 0.25;

/// How many other bodies a body has at each distance, as a mean over bodies and moments; nearest images.
#[derive(Debug, Clone, Default)]
pub struct Neighbours {
    /// Sums over the moments, per bin.
    counts: Vec<f64>,
    moments: f64,
}

impl Neighbours {
    /// Adds one moment.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn add(&mut self, system: &System, bodies: &[Squirmer]) {
        self.moments += 1.0;
        for (i, a) in bodies.iter().enumerate() {
            for b in &bodies[..i] {
                let r = nearest_image(&system.domain, a.position - b.position).length();
                let bin = (r / BIN) as usize;
                if self.counts.len() <= bin {
                    self.counts.resize(bin + 1, 0.0);
                }
                self.counts[bin] += 2.0 / bodies.len() as f64;
            }
        }
    }

    /// Mean over bodies and moments of the sum over neighbours of a function of their distance.
    pub fn sum(&self, term: impl Fn(f64) -> f64) -> f64 {
        let filled = self.counts.iter().enumerate().filter(|(_, n)| **n > 0.0);
        filled.map(|(bin, n)| n / self.moments * term(BIN * (bin as f64 + 0.5))).sum()
    }
}

/// The share that a neighbour at the distance r has of its final effect on a body's diffusion, as a mean over the lags `from..to`.
///
/// A free body resists the straining of the fluid with a stresslet, whose flow comes back: -(15/4) R^4/r^4 along the line of
/// centres (Batchelor, J. Fluid Mech. 74, 1, 1976). Vorticity needs r^2/nu each way. By reciprocity the effect is the strain rate E
/// of a point force at that distance, squared; at the rate s it is that of the unsteady Stokes equation (Kim and Karrila,
/// Microhydrodynamics, 1991, section 6.2), with x = r sqrt(s/nu): G = (A(x) 1 + B(x) r r/r^2)/(8 pi eta r). The mean squared
/// displacement belongs to E^2/s^2, whose original is found by Stehfest's sum (Commun. ACM 13, 47, 1970).
pub fn arrived(r: f64, nu: f64, (from, to): (f64, f64)) -> f64 {
    let grown = |t: f64| original(|s| squared_strain(r * (s / nu).sqrt()) / (s * s), t);
    let before = if from > 0.0 { grown(from) } else { 0.0 };
    (grown(to) - before) / (to - from)
}

/// E:E of an oscillating point force, averaged over its directions, over that of a steady one.
fn squared_strain(x: f64) -> f64 {
    let (e, x2) = (2.0 * (-x).exp(), x * x);
    let a = e * (1.0 + 1.0 / x + 1.0 / x2) - 2.0 / x2;
    let b = -e * (1.0 + 3.0 / x + 3.0 / x2) + 6.0 / x2;
    // x A'(x).
    let slope = -e * (x + 1.0 + 2.0 / x + 2.0 / x2) + 4.0 / x2;
    (6.0 * b * b + (slope - a + b).powi(2)) / 6.0
}

/// The function of time t whose Laplace transform is given on the positive axis.
fn original(transform: impl Fn(f64) -> f64, t: f64) -> f64 {
    const N: u32 = 12;
    let half = N / 2;
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    let weight = |k: u32| {
        let term = |j: u32| {
            f64::from(j).powi(half.cast_signed()) * factorial(2 * j)
                / (factorial(half - j) * factorial(j) * factorial(j - 1) * factorial(k - j) * factorial(2 * j - k))
        };
        let sign = if (k + half).is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * (k.div_ceil(2)..=k.min(half)).map(term).sum::<f64>()
    };
    let rate = std::f64::consts::LN_2 / t;
    rate * (1..=N).map(|k| weight(k) * transform(f64::from(k) * rate)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_transforms_come_back() {
        for t in [0.5, 2.0] {
            assert!((original(|s| 1.0 / (s * s), t) / t - 1.0).abs() < 1e-6);
            assert!((original(|s| 1.0 / (s + 1.0), t) - (-t).exp()).abs() < 1e-3);
        }
    }

    /// A steady force, and one that has had no time: beyond a few sqrt(nu t) there is only the dipole of the pressure.
    #[test]
    fn the_strain_of_a_point_force_has_its_limits() {
        assert!((squared_strain(1e-3) - 1.0).abs() < 2e-3);
        // A = -2/x^2, B = 6/x^2: 6 B^2 + (4 + 2 + 6)^2/x^4.
        let x = 200.0f64;
        assert!((squared_strain(x) * x.powi(4) / ((216.0 + 144.0) / 6.0) - 1.0).abs() < 1e-9);
    }

    /// By multiple-precision inversion along Talbot's contour, nu = 0.425.
    #[test]
    fn a_neighbour_is_felt_late() {
        for (r, lags, share) in [
            (6.0, (30.0, 60.0), 0.7778),
            (10.0, (12.0, 24.0), 0.1562),
            (10.0, (30.0, 60.0), 0.4513),
            (16.0, (30.0, 60.0), 0.1504),
            (20.0, (100.0, 200.0), 0.3868),
        ] {
            let found = arrived(r, 0.425, lags);
            assert!((found - share).abs() < 2e-3, "{r} {lags:?}: {found}, not {share}");
        }
        assert!((arrived(8.0, 0.425, (1e5, 2e5)) - 1.0).abs() < 0.01);
    }
}

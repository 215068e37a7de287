//! Fixed-point scales of the cell moments: chosen so that a sum cannot overflow while the run-time checks hold.
//!
//! Sums over particles are integers, so their result does not depend on the order of addition. A particle adds
//! round(scale * quantity). The checks made each step are: at most `max_count` contributions per cell, and a
//! sum of squared speeds that has not wrapped (a second, coarse sum must agree). Cauchy and Schwarz bound all the others:
//! |sum v| <= sqrt(N Q), |sum x v| <= sqrt(N/4 Q), |sum x| <= N/2, |sum x x| <= N/4, with Q = sum |v|^2 and |x| <= 1/2.

/// Scales and limits of the moment sums, in units of the cell edge and of the velocity unit of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Contributions per cell (fluid and ghosts) up to which the sums are safe.
    pub max_count: u32,
    /// Speed of one particle up to which its contribution is safe.
    pub max_speed: f64,
    /// Scale of sum v.
    pub velocity: f64,
    /// Scale of sum |v|^2 (unsigned).
    pub energy: f64,
    /// Scale of the coarse copy of sum |v|^2 that betrays a wrapped fine one.
    pub energy_coarse: f64,
    /// Bit of the word of the count from which on it holds the coarse copy.
    pub coarse_bit: u32,
    /// Scale of sum x.
    pub position: f64,
    /// Scale of sum x x^T.
    pub second: f64,
    /// Scale of sum x v^T.
    pub mixed: f64,
}

/// The power of two next to the thermal speed sqrt(kT/m): the unit in which velocities and impulses are counted.
#[must_use]
pub fn thermal_unit(temperature: f64) -> f64 {
    temperature.sqrt().log2().round().exp2()
}

impl Scales {
    /// Scales for a mean density (particles per cell) and temperature (kT).
    #[must_use]
    pub fn new(density: f64, temperature: f64) -> Self {
        // Twelve standard deviations of a Poisson law above the mean, and room for a few particles in an empty fluid.
        let wanted = density + 12.0 * density.sqrt() + 40.0;
        let max_count = wanted.log2().ceil().exp2();
        let thermal = thermal_unit(temperature);
        let q_max = 4096.0; // 2^32 / 2^20, in units of thermal^2
        // Half a unit of error from each of max_count particles is an eighth of q_max, and as many of the fastest ones, 144 of these units,
        // make less than max_count^2 / 4 coarse units.
        let per_thermal = 4.0 * max_count / q_max;
        let coarse_bits = 2.0 * max_count.log2() - 2.0;
        let fit = |bound: f64| (2f64.powi(31) / bound).log2().ceil().exp2() / 2.0;
        Self {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            max_count: max_count as u32,
            max_speed: 12.0 * thermal,
            velocity: fit((max_count * q_max).sqrt()) / thermal,
            energy: 2f64.powi(20) / (thermal * thermal),
            energy_coarse: per_thermal / (thermal * thermal),
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            coarse_bit: 32 - coarse_bits as u32,
            position: fit(max_count / 2.0),
            second: fit(max_count / 4.0),
            mixed: fit((max_count / 4.0 * q_max).sqrt()) / thermal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_at_the_limits_fit_in_31_bits() {
        for (density, temperature) in [(0.0, 1.0), (10.0, 1.0), (10.0, 0.3), (50.0, 1.0), (200.0, 7.0), (1000.0, 1.0)] {
            let s = Scales::new(density, temperature);
            let n = f64::from(s.max_count);
            let q = 2f64.powi(32) / s.energy;
            let limit = 2f64.powi(31);
            assert!(n >= density + 12.0 * density.sqrt());
            assert!((n * q).sqrt() * s.velocity < limit);
            assert!((n / 4.0 * q).sqrt() * s.mixed < limit);
            assert!(n / 2.0 * s.position < limit && n / 4.0 * s.second < limit);
            // What shaders round in two operations stays within 2^22.
            assert!(s.max_speed * s.max_speed * s.energy_coarse < 2f64.powi(22));
            // The coarse sum never wraps: it holds max_count of the fastest particles. The count beneath it does not either.
            let most = n * (s.max_speed * s.max_speed * s.energy_coarse + 0.5);
            assert!(most < 2f64.powi(32 - s.coarse_bit.cast_signed()));
            assert!(2.0 * n <= 2f64.powi(s.coarse_bit.cast_signed()));
            // A fine sum that has wrapped stands out of what the coarse one may be wrong by.
            assert!(2.0 * (0.51 * n / s.energy_coarse + 1e-5 * q) < q);
            // Scales are not wastefully small either: four times larger would break a bound.
            assert!(4.0 * (n * q).sqrt() * s.velocity >= limit);
        }
    }
}

//! Many sums over time at once, kept in stretches: means with errors in a memory that does not grow with the run.

use super::statistics::{Estimate, blocked};

/// Stretches kept at most. When they are full, neighbours are joined, so that there are always at least half as many.
const MOST: usize = 64;
/// Stretches that must have data for an error to mean something.
const LEAST: usize = 4;

/// Sums of `width` quantities over each stretch of snapshots. Joining neighbours is what blocking does to a series
/// anyway, so that correlations shorter than a 64th of the run are gone before [`blocked`] looks for the longer ones.
#[derive(Debug, Clone, Default)]
pub struct Stretches {
    width: usize,
    sums: Vec<Vec<f64>>,
    counts: Vec<u64>,
    length: u64,
}

impl Stretches {
    /// No snapshots yet.
    #[must_use]
    pub fn new(width: usize) -> Self {
        Self { width, sums: Vec::new(), counts: Vec::new(), length: 1 }
    }

    /// Begins the next snapshot: its values are to be added to what is returned.
    pub fn begin(&mut self) -> &mut [f64] {
        if self.counts.last().is_none_or(|n| *n == self.length) {
            if self.sums.len() == MOST {
                self.join();
            }
            self.sums.push(vec![0.0; self.width]);
            self.counts.push(0);
        }
        let last = self.sums.len() - 1;
        self.counts[last] += 1;
        &mut self.sums[last]
    }

    fn join(&mut self) {
        for i in 0..MOST / 2 {
            let right = std::mem::take(&mut self.sums[2 * i + 1]);
            let mut left = std::mem::take(&mut self.sums[2 * i]);
            left.iter_mut().zip(right).for_each(|(l, r)| *l += r);
            self.sums[i] = left;
            self.counts[i] = self.counts[2 * i] + self.counts[2 * i + 1];
        }
        self.sums.truncate(MOST / 2);
        self.counts.truncate(MOST / 2);
        self.length *= 2;
    }

    /// How many quantities there are.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Snapshots taken.
    #[must_use]
    pub fn snapshots(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Sum of one quantity over all snapshots.
    #[must_use]
    pub fn total(&self, quantity: usize) -> f64 {
        self.sums.iter().map(|s| s[quantity]).sum()
    }

    /// Mean of one quantity over the snapshots.
    #[must_use]
    pub fn mean(&self, quantity: usize) -> Estimate {
        self.of(|sums, _| sums[quantity], |_, count| count as f64)
    }

    /// The sum of one quantity over that of another.
    #[must_use]
    pub fn ratio(&self, above: usize, below: usize) -> Estimate {
        self.of(|sums, _| sums[above], |sums, _| sums[below])
    }

    /// Ratio A/B of what is made of the sums of a stretch and its number of snapshots, both summed over the stretches.
    /// The error is that of the mean of (a - b A/B) over the mean of b, which is linear in the stretches (delta
    /// method); NaN if fewer than four stretches have a b.
    pub fn of(&self, above: impl Fn(&[f64], u64) -> f64, below: impl Fn(&[f64], u64) -> f64) -> Estimate {
        let all: Vec<(f64, f64)> =
            self.sums.iter().zip(&self.counts).map(|(s, n)| (above(s, *n), below(s, *n))).collect();
        let (a, b) = all.iter().fold((0.0, 0.0), |(a, b), s| (a + s.0, b + s.1));
        let mean = a / b;
        // The last stretch may not be full yet, and would scatter more than the others.
        let full = self.counts.iter().take_while(|n| **n == self.length).count();
        let whole = &all[..full];
        if whole.iter().filter(|s| s.1 != 0.0).count() < LEAST {
            return Estimate { mean, error: f64::NAN };
        }
        let weight = whole.iter().map(|s| s.1).sum::<f64>() / full as f64;
        let deviations: Vec<f64> = whole.iter().map(|(a, b)| (a - mean * b) / weight).collect();
        Estimate { mean, error: blocked(&deviations).error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::draws::normals;
    use crate::math::rng::{Draw, Purpose};

    #[test]
    fn sums_survive_joining() {
        for n in [1, 4, 63, 64, 65, 127, 128, 129, 1000] {
            let mut sums = Stretches::new(2);
            for i in 0..n {
                let now = sums.begin();
                now[0] += f64::from(i);
                now[1] += 2.0;
            }
            assert_eq!((sums.snapshots(), sums.total(0)), (n as u64, f64::from(n * (n - 1) / 2)));
            assert_eq!((sums.mean(0).mean, sums.ratio(0, 1).mean), (f64::from(n - 1) / 2.0, f64::from(n - 1) / 4.0));
            assert_eq!(sums.mean(1).error.is_nan(), n < 4);
            assert!(n < 4 || sums.mean(1).error == 0.0);
            assert!(sums.sums.len() <= MOST && sums.sums[..].iter().all(|s| s.len() == 2));
        }
    }

    #[test]
    fn too_few_stretches_have_no_error() {
        let mut sums = Stretches::new(2);
        for i in 0..40 {
            let now = sums.begin();
            if i < 3 {
                now[0] += f64::from(i);
                now[1] += 1.0;
            }
        }
        let found = sums.ratio(0, 1);
        assert!(found.mean == 1.0 && found.error.is_nan(), "{found:?}");
    }

    /// x' = phi x + noise of unit variance, whose mean of n has the variance (1 + phi)/(1 - phi)/(1 - phi^2)/n; 400
    /// independent series.
    #[test]
    fn errors_of_correlated_series_are_right_also_after_joining() {
        let (phi, n, width) = (0.9f64, 3000u64, 400);
        let mut sums = Stretches::new(width);
        let mut x = vec![0.0; width];
        for step in 0..n + 100 {
            let draw = Draw::new(1, Purpose::Start, step);
            for (i, x) in (0u32..).zip(&mut x) {
                *x = phi * *x + normals(draw.uniforms(i, 0, 0)).x;
            }
            if step >= 100 {
                sums.begin().iter_mut().zip(&x).for_each(|(s, x)| *s += x);
            }
        }
        let exact = ((1.0 + phi) / (1.0 - phi) / (1.0 - phi * phi) / n as f64).sqrt();
        let errors = (0..width).map(|i| sums.mean(i).error.powi(2)).sum::<f64>() / width as f64;
        // One error from some 40 blocks scatters by a tenth, 400 by half a per cent; correlation between blocks leaves
        // a few per cent.
        assert!((errors.sqrt() / exact - 1.0).abs() < 0.05, "{} {exact}", errors.sqrt());
        let scatter = (0..width).map(|i| sums.mean(i).mean.powi(2)).sum::<f64>() / width as f64;
        // The scatter of 400 means is known to 1/sqrt(800) = 3.5 %: five of these.
        assert!((scatter.sqrt() / exact - 1.0).abs() < 0.18, "{} {exact}", scatter.sqrt());
        // Negative control: the naive error of the values themselves is far too small.
        let naive = 1.0 / (1.0 - phi * phi).sqrt() / (n as f64).sqrt();
        assert!(naive < 0.3 * exact);
    }
}

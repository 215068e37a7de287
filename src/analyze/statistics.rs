//! Means of correlated series and their errors.

/// A mean and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// Standard error of the mean; NaN where one value says nothing about it.
    pub error: f64,
}

impl Estimate {
    /// Nothing known.
    pub const NONE: Self = Self { mean: f64::NAN, error: f64::NAN };
}

/// Arithmetic mean; NaN of nothing.
#[must_use]
pub fn mean(series: &[f64]) -> f64 {
    series.iter().sum::<f64>() / series.len() as f64
}

/// Mean of independent values with its standard error.
#[must_use]
pub fn independent(values: &[f64]) -> Estimate {
    let (n, mean) = (values.len() as f64, mean(values));
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let error = if values.len() < 2 { f64::NAN } else { (squares / (n - 1.0) / n).sqrt() };
    Estimate { mean, error }
}

/// Mean of a correlated series, its error by blocking: neighbours are averaged in pairs until what remains is
/// uncorrelated (Flyvbjerg and Petersen 1989, J. Chem. Phys. 91, 461). Which level that is, is decided by the test of
/// Jonsson 2018 (Phys. Rev. E 98, 043304, eqs. 21 to 23) at 99 percent. The test passes as soon as correlation cannot be
/// seen, which leaves errors a tenth too small; two levels more, while 16 blocks remain, leave a fortieth.
#[must_use]
pub fn blocked(series: &[f64]) -> Estimate {
    let mean = mean(series);
    let mut levels: Vec<(f64, f64, f64)> = Vec::new();
    let mut level = series.to_vec();
    while level.len() >= 2 {
        let n = level.len() as f64;
        let variance = level.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        let lag_one = level.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>() / n;
        levels.push((n, variance, lag_one));
        level = level.as_chunks::<2>().0.iter().map(|[a, b]| f64::midpoint(*a, *b)).collect();
    }
    // Statistic of level k: a sum over k and all coarser levels, chi-squared distributed if they are uncorrelated.
    let mut statistic = 0.0;
    let mut chosen = levels.len().saturating_sub(1);
    for k in (0..levels.len()).rev() {
        let (n, variance, lag_one) = levels[k];
        if variance > 0.0 {
            statistic += n * ((n - 1.0) * variance / (n * n) + lag_one).powi(2) / variance.powi(2);
        }
        if statistic < chi_squared_99((levels.len() - k) as f64) {
            chosen = k;
        } else {
            break;
        }
    }
    for _ in 0..2 {
        chosen += usize::from(levels.get(chosen + 1).is_some_and(|level| level.0 >= 16.0));
    }
    let error = levels.get(chosen).map_or(f64::NAN, |(n, variance, _)| (variance / (n - 1.0)).sqrt());
    Estimate { mean, error }
}

/// Points of the course of a series in time, at most.
const COURSE: usize = 60;

/// The course of a series for a chart: time, mean and error of up to 60 stretches.
#[must_use]
pub fn course(times: &[f64], series: &[f64]) -> Vec<(f64, f64, f64)> {
    let size = series.len().div_ceil(COURSE).max(1);
    let stretch = |(times, values): (&[f64], &[f64])| {
        let found = blocked(values);
        (mean(times), found.mean, found.error)
    };
    times.chunks(size).zip(series.chunks(size)).map(stretch).collect()
}

/// 99 percent quantile of chi-squared (Wilson and Hilferty 1931), better than 1 percent from 3 degrees of freedom on.
fn chi_squared_99(degrees: f64) -> f64 {
    let a = 2.0 / (9.0 * degrees);
    degrees * (1.0 - a + 2.326_348 * a.sqrt()).powi(3)
}

/// Error by the delete-one-block jackknife: `estimate` is evaluated without each of `blocks` stretches of `0..n` in turn
/// (Quenouille 1956; Tukey 1958). The stretches must be longer than the correlation time.
pub fn jackknife(n: usize, blocks: usize, estimate: impl Fn(&dyn Fn(usize) -> bool) -> f64) -> f64 {
    let blocks = blocks.min(n);
    if blocks < 2 {
        return f64::NAN;
    }
    let without = |b: usize| estimate(&|i| i * blocks / n != b);
    let values: Vec<f64> = (0..blocks).map(without).collect();
    let mean = mean(&values);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let b = blocks as f64;
    (squares * (b - 1.0) / b).sqrt()
}

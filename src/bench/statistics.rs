//! A median and how far values lie about it.

use serde::{Deserialize, Serialize};

/// The middle of some values, and the range that holds four fifths of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// 10th percentile.
    pub low: f64,
    /// 90th percentile.
    pub high: f64,
}

impl Spread {
    /// Of these values; `None` without any.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share| percentile(&sorted, share);
        Some(Self { median: at(0.5)?, low: at(0.1)?, high: at(0.9)? })
    }

    /// The same values, each multiplied by a positive factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { median: self.median * factor, low: self.low * factor, high: self.high * factor }
    }

    /// Width of the range.
    #[must_use]
    pub fn width(self) -> f64 {
        self.high - self.low
    }
}

/// The value below which this share of the sorted values lies, linear between neighbours.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let (below, rest) = (place.floor() as usize, place.fract());
    let above = (below + 1).min(sorted.len() - 1);
    Some(sorted[below] + rest * (sorted[above] - sorted[below]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_lie_between_neighbours() {
        let values: Vec<f64> = (0..=10).rev().map(f64::from).collect();
        assert_eq!(Spread::of(&values), Some(Spread { median: 5.0, low: 1.0, high: 9.0 }));
        assert_eq!(Spread::of(&[1.0, 4.0, 2.0, 3.0]).map(|s| s.median), Some(2.5));
        assert_eq!(Spread::of(&[1.0, 2.0]).map(|s| (s.low, s.high)), Some((1.1, 1.9)));
        assert_eq!(Spread::of(&[7.0]), Some(Spread { median: 7.0, low: 7.0, high: 7.0 }));
        assert_eq!(Spread::of(&[]), None);
    }

    #[test]
    fn one_outlier_moves_neither_median_nor_range_far() {
        let mut values = vec![1.0; 20];
        values[3] = 1000.0;
        assert_eq!(Spread::of(&values), Some(Spread { median: 1.0, low: 1.0, high: 1.0 }));
    }

    #[test]
    fn a_factor_scales_all_three() {
        let spread = Spread { median: 2.0, low: 1.0, high: 4.0 };
        assert_eq!(spread.times(0.5), Spread { median: 1.0, low: 0.5, high: 2.0 });
        assert_eq!(spread.width(), 3.0);
    }
}

//! Which snapshots are meant: from a step or a time to another, and every how many.

use super::RecordingError;
use crate::wire::{Header, Kind};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// A moment of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moment {
    /// After so many steps.
    Step(u64),
    /// At this time in tau.
    Time(f64),
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(step) => write!(f, "step {step}"),
            Self::Time(time) => write!(f, "{time} tau"),
        }
    }
}

impl FromStr for Moment {
    type Err = String;

    /// A whole number is a step; a number followed by `tau` is a time.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is neither a step, as in 2000, nor a time, as in 12.5tau");
        match text.trim().strip_suffix("tau") {
            Some(time) => {
                let time: f64 = time.trim().parse().map_err(|_| wrong())?;
                if time.is_finite() { Ok(Self::Time(time)) } else { Err(wrong()) }
            }
            None => text.trim().parse().map(Self::Step).map_err(|_| wrong()),
        }
    }
}

/// Snapshots between two moments, both included, and of those of each kind every so many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// From here on.
    pub from: Option<Moment>,
    /// Up to here.
    pub to: Option<Moment>,
    /// 1 for all, 2 for the first, the third and so on.
    pub every: u64,
}

impl Default for Range {
    fn default() -> Self {
        Self { from: None, to: None, every: 1 }
    }
}

impl Range {
    /// The range, unless it ends before it begins. A step and a time do not compare without the recording.
    ///
    /// # Errors
    /// If it is reversed.
    pub fn forward(self) -> Result<Self, RecordingError> {
        let reversed = match (self.from, self.to) {
            (Some(Moment::Step(from)), Some(Moment::Step(to))) => from > to,
            (Some(Moment::Time(from)), Some(Moment::Time(to))) => from > to,
            _ => false,
        };
        match (self.from, self.to) {
            (Some(from), Some(to)) if reversed => Err(RecordingError::Reversed { from, to }),
            _ => Ok(self),
        }
    }

    /// Whether the snapshot lies between the two moments.
    #[must_use]
    pub fn contains(&self, header: &Header) -> bool {
        !self.before(header) && !self.after(header)
    }

    /// Whether the snapshot comes before the range.
    #[must_use]
    pub fn before(&self, header: &Header) -> bool {
        match self.from {
            None => false,
            Some(Moment::Step(step)) => header.step < step,
            Some(Moment::Time(time)) => header.time < time,
        }
    }

    /// Whether the snapshot comes after the range; then all later ones do.
    #[must_use]
    pub fn after(&self, header: &Header) -> bool {
        match self.to {
            None => false,
            Some(Moment::Step(step)) => header.step > step,
            Some(Moment::Time(time)) => header.time > time,
        }
    }
}

/// Chooses from snapshots that come in order.
#[derive(Debug, Clone, Default)]
pub struct Choice {
    range: Range,
    seen: BTreeMap<(Kind, u64), u64>,
}

impl Choice {
    /// Chooses those of `range`.
    #[must_use]
    pub fn new(range: Range) -> Self {
        Self { range, seen: BTreeMap::new() }
    }

    /// Whether this snapshot is one of them; to be asked once for each.
    pub fn takes(&mut self, kind: Kind, header: &Header) -> bool {
        if !self.range.contains(header) {
            return false;
        }
        let seen = self.seen.entry((kind, header.every)).or_default();
        *seen += 1;
        (*seen - 1).is_multiple_of(self.range.every.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Stamp;

    #[test]
    fn moments_are_steps_or_times() {
        assert_eq!("2000".parse(), Ok(Moment::Step(2000)));
        assert_eq!("12.5tau".parse(), Ok(Moment::Time(12.5)));
        assert_eq!(" 3 tau".parse(), Ok(Moment::Time(3.0)));
        for wrong in ["", "tau", "12.5", "-1", "nantau", "5s"] {
            assert!(wrong.parse::<Moment>().unwrap_err().contains("neither a step"), "{wrong}");
        }
    }

    #[test]
    fn a_range_includes_both_ends_and_counts_from_its_first() {
        let header =
            |step: u64| Header::new(Kind::Scalars, &Stamp { step, time: step as f64 * 0.5, ..Stamp::default() });
        let chosen = |range: Range| -> Vec<u64> {
            let mut choice = Choice::new(range);
            (0..10).filter(|step| choice.takes(Kind::Scalars, &header(*step))).collect()
        };
        let (from, to) = (Some(Moment::Step(3)), Some(Moment::Time(4.0)));
        assert_eq!(chosen(Range { from, to, every: 1 }), [3, 4, 5, 6, 7, 8]);
        assert_eq!(chosen(Range { from, to, every: 2 }), [3, 5, 7]);
        assert_eq!(chosen(Range { every: 4, ..Range::default() }), [0, 4, 8]);
        let time = |time| Some(Moment::Time(time));
        assert!(Range { from, to: from, every: 1 }.forward().is_ok() && Range { from, to, every: 1 }.forward().is_ok());
        let reversed = Range { from: time(5.0), to: time(2.5), every: 1 }.forward().unwrap_err().to_string();
        assert_eq!(reversed, "the range is reversed: it begins at 5 tau and ends at 2.5 tau");
        assert!(Range { from, to: Some(Moment::Step(2)), every: 1 }.forward().is_err());
    }
}

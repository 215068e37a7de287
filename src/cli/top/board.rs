//! What `squirm top` knows of a run: its last status, how its numbers went, who reads it, and whether it has ended.

use crate::cli::watch;
use squirm::wire::{Kind, Stamp, Status};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Statuses that are remembered: one a second.
const MEMORY: usize = 600;
/// A run that has said nothing for so long is stopped, or in a very long step.
pub const SILENCE: Duration = Duration::from_secs(4);

/// What comes to a board.
pub enum News {
    /// The run's status.
    Status(Stamp, Box<Status>),
    /// Its topics and their subscribers.
    Topics(Vec<(Kind, usize)>),
    /// It publishes no more; why, if that was an error of watching.
    Over(Option<String>),
}

/// One number over time, the newest last.
#[derive(Default)]
pub struct Track(VecDeque<f64>);

impl Track {
    fn push(&mut self, value: f64) {
        if value.is_finite() {
            self.0.push_back(value);
        }
        if self.0.len() > MEMORY {
            self.0.pop_front();
        }
    }

    /// The newest `width` values as heights from 1 to 8 between their least and their greatest; equal ones stand in the middle.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn heights(&self, width: usize) -> Vec<u64> {
        let shown: Vec<f64> = self.0.iter().skip(self.0.len().saturating_sub(width)).copied().collect();
        let (low, high) = range(&shown);
        let height = |v: &f64| if high > low { 1 + (7.0 * (v - low) / (high - low)).round() as u64 } else { 4 };
        shown.iter().map(height).collect()
    }

    /// Least and greatest of the newest `width` values.
    pub fn range(&self, width: usize) -> Option<(f64, f64)> {
        let shown: Vec<f64> = self.0.iter().skip(self.0.len().saturating_sub(width)).copied().collect();
        (!shown.is_empty()).then(|| range(&shown))
    }
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (v.min(low), v.max(high)))
}

/// The board.
pub struct Board {
    /// Name of the run.
    pub run: String,
    /// Its last status.
    pub last: Option<(Stamp, Status)>,
    /// Speed in steps per second.
    pub speed: Track,
    /// Temperature in kT.
    pub temperature: Track,
    /// Swim speed in sqrt(kT/m).
    pub swim_speed: Track,
    /// Topics and their subscribers, but the status.
    pub topics: Vec<(Kind, usize)>,
    over: Option<Option<String>>,
    heard: Instant,
}

impl Board {
    /// An empty board.
    pub fn new(run: &str) -> Self {
        Self {
            run: watch::tame(run),
            last: None,
            speed: Track::default(),
            temperature: Track::default(),
            swim_speed: Track::default(),
            topics: Vec::new(),
            over: None,
            heard: Instant::now(),
        }
    }

    /// Enters news.
    pub fn take(&mut self, news: News) {
        match news {
            News::Status(stamp, status) => {
                self.heard = Instant::now();
                // The first status after the start knows no speed yet.
                if status.speed > 0.0 {
                    self.speed.push(status.speed);
                }
                self.temperature.push(status.temperature);
                self.swim_speed.push(status.swim_speed);
                self.last = Some((stamp, *status));
            }
            News::Topics(topics) if self.is_going() => {
                self.topics = topics.into_iter().filter(|(kind, _)| *kind != Kind::Status).collect();
            }
            News::Topics(_) => {}
            News::Over(error) => self.over = Some(error),
        }
    }

    /// Whether the run still publishes.
    pub fn is_going(&self) -> bool {
        self.over.is_none()
    }

    /// Whether it ended without a word, or with an error.
    pub fn died(&self) -> bool {
        let phase = self.last.as_ref().map_or("", |(_, status)| status.phase.as_str());
        self.over.is_some() && phase != Status::ENDED
    }

    /// What there is to say about its end or silence.
    pub fn ending(&self) -> String {
        let step = self.last.as_ref().map_or(0, |(stamp, _)| stamp.step);
        let phase = self.last.as_ref().map_or("", |(_, status)| status.phase.as_str());
        match &self.over {
            None if self.heard.elapsed() > SILENCE => {
                format!("no word from the run for {}", watch::time(self.heard.elapsed().as_secs_f64()))
            }
            None => Status::RUNNING.into(),
            Some(Some(error)) => format!("the run cannot be watched any more: {error}"),
            Some(None) => match phase {
                Status::ENDED => format!("the run has ended after {step} steps"),
                Status::RUNNING | "" => format!("the run has died after {step} steps or more: it was killed"),
                failed => format!("after {step} steps the run has {}", watch::tame(failed)),
            },
        }
    }

    /// Everything important in one line.
    pub fn line(&self) -> String {
        let Some((stamp, status)) = &self.last else { return format!("{}: no status yet", self.run) };
        let left = watch::left(stamp.step, status).map_or("?".into(), watch::time);
        let mut line = format!(
            "{}: step {} of {} ({:.1} %), {} steps/s, {left} left",
            self.run,
            stamp.step,
            status.steps,
            watch::share(stamp.step, status),
            watch::rate(status.speed)
        );
        let numbers = [("temperature", status.temperature, "kT"), ("swim speed", status.swim_speed, "sqrt(kT/m)")];
        for (name, value, unit) in numbers.into_iter().filter(|(_, value, _)| value.is_finite()) {
            line += &format!(", {name} {value:.4} {unit}");
        }
        if status.dropped > 0 {
            line += &format!(", {} dropped", status.dropped);
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_fill_the_range_of_what_is_shown() {
        let mut track = Track::default();
        [9.0, f64::NAN, 1.0, 2.0, 8.0].into_iter().for_each(|v| track.push(v));
        assert_eq!((track.heights(3), track.range(3)), (vec![1, 2, 8], Some((1.0, 8.0))));
        assert_eq!(track.heights(1), [4]);
        (0..2 * MEMORY).for_each(|_| track.push(0.0));
        assert_eq!(track.heights(usize::MAX).len(), MEMORY);
    }

    #[test]
    fn an_end_an_error_and_a_death_are_told_apart() {
        let ended = |phase: &str| {
            let mut board = Board::new("r");
            let stamp = Stamp { step: 7, ..Stamp::default() };
            let status = Status { phase: phase.into(), ..Status::default() };
            board.take(News::Status(stamp, Box::new(status)));
            assert!(board.is_going() && !board.died());
            board.take(News::Over(None));
            (board.died(), board.ending())
        };
        assert_eq!(ended("ended"), (false, "the run has ended after 7 steps".into()));
        assert_eq!(ended("running"), (true, "the run has died after 7 steps or more: it was killed".into()));
        assert_eq!(ended("failed: disk full"), (true, "after 7 steps the run has failed: disk full".into()));
    }
}

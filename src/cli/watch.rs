//! What `ps`, `top` and `tap` share: statuses of runs that are going, and numbers for people.

use squirm::analyze::{Limits, Live, Source};
use squirm::wire::{Kind, Stamp, Status};
use std::ops::ControlFlow;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Longest time for which a run may keep its newest status from a newcomer; runs give it within a fifth of a second.
const PATIENCE: Duration = Duration::from_secs(2);

/// The newest status of a run; `None` for one that has none, or is just ending.
pub fn status(run: &str) -> Option<(Stamp, Status)> {
    let limits = Limits { snapshots: Some(1), duration: Some(PATIENCE), ..Limits::default() };
    let mut found = None;
    let ending = Live::new(run, limits).drive(&[Kind::Status], &mut |snapshot| {
        found = Some((snapshot.header.stamp(), Status::decode(snapshot)?));
        Ok(ControlFlow::Break(()))
    });
    ending.ok().and(found)
}

/// Wall time that is left in seconds; `None` while it cannot be known.
#[allow(clippy::cast_precision_loss)]
pub fn left(step: u64, status: &Status) -> Option<f64> {
    let known = status.speed > 0.0 && status.steps >= step;
    known.then(|| (status.steps - step) as f64 / status.speed)
}

/// Seconds since the run began.
pub fn age(status: &Status) -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64() - status.started
}

/// A share in per cent of the steps that are done.
#[allow(clippy::cast_precision_loss)]
pub fn share(step: u64, status: &Status) -> f64 {
    if status.steps == 0 { 0.0 } else { (100.0 * step as f64 / status.steps as f64).clamp(0.0, 100.0) }
}

/// A time in its two largest units: `3 d 4 h`, `5 min 2 s`, `0.8 s`.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn time(seconds: f64) -> String {
    if !(0.0..1e12).contains(&seconds) {
        return "?".into();
    }
    if seconds < 10.0 {
        return format!("{seconds:.1} s");
    }
    let s = seconds.round() as u64;
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{} min {} s", s / 60, s % 60),
        3600..86400 => format!("{} h {} min", s / 3600, s % 3600 / 60),
        _ => format!("{} d {} h", s / 86400, s % 86400 / 3600),
    }
}

/// A rate with three digits or more.
pub fn rate(value: f64) -> String {
    match value.abs() {
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

/// Text that another program wrote, without what a terminal would obey.
pub fn tame(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_their_two_largest_units() {
        let cases =
            [(0.84, "0.8 s"), (59.4, "59 s"), (302.0, "5 min 2 s"), (3660.0, "1 h 1 min"), (273_600.0, "3 d 4 h")];
        cases.iter().for_each(|(seconds, text)| assert_eq!(time(*seconds), *text));
        assert_eq!((time(f64::NAN).as_str(), time(-1.0).as_str()), ("?", "?"));
    }

    #[test]
    fn what_is_left_follows_from_the_speed() {
        let status = Status { steps: 300, speed: 50.0, ..Status::default() };
        assert_eq!((left(100, &status), share(75, &status)), (Some(4.0), 25.0));
        assert_eq!(left(100, &Status { speed: 0.0, ..status.clone() }), None);
        assert_eq!(left(301, &status), None, "a run that goes on behind its end");
        assert_eq!(tame("a\x1b[2Jb"), "a?[2Jb");
    }
}

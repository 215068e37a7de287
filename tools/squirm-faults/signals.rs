//! Signals: a run that is told to end ends soon, with everything complete, and one that is told twice leaves at once.

use super::child::{ENDLESS, Trial};
use super::kill::saved_step;
use super::record::frames;
use super::table::Row;
use rand::{Rng, RngExt};
use std::path::Path;
use std::time::{Duration, Instant};

/// What a run has to end within.
const LIMIT: Duration = Duration::from_secs(5);

/// Signals and the status with which a run ends.
const SIGNALS: [(&str, i32); 3] = [("-INT", 130), ("-TERM", 143), ("-USR1", 143)];

/// Waits until the run has written a checkpoint after its start.
fn under_way(trial: &Trial) -> Result<(), String> {
    let began = Instant::now();
    while saved_step(&trial.dir())?.unwrap_or(0) == 0 {
        if began.elapsed() > Duration::from_secs(120) {
            return Err("it writes no checkpoint".into());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Ok(())
}

/// Sends `count` signals at random instants, and then twice as many in pairs.
pub fn signals(squirm: &Path, count: u32, random: &mut impl Rng) -> Result<Vec<Row>, String> {
    let mut once = Row::new("a signal ends a run within 5 s with its status, a checkpoint and complete recordings");
    let mut twice = Row::new("a second signal ends it at once, and a checkpoint is there");
    let (mut longest, mut at_once) = (Duration::ZERO, Duration::ZERO);
    for number in 0..count {
        let (signal, status) = SIGNALS[number as usize % SIGNALS.len()];
        let pause = Duration::from_millis(random.random_range(0..700));
        once.enter(stopped(squirm, signal, status, pause).map(|took| longest = longest.max(took)));
        twice.enter(pressed(squirm, signal, status, pause).map(|took| at_once = at_once.max(took)));
    }
    once.figures = format!("longest {:.2} s", longest.as_secs_f64());
    twice.figures = format!("longest {:.2} s", at_once.as_secs_f64());
    Ok(vec![once, twice])
}

fn stopped(squirm: &Path, signal: &str, status: i32, pause: Duration) -> Result<Duration, String> {
    let trial = Trial::new(squirm, &ENDLESS)?;
    let process = trial.start()?;
    under_way(&trial)?;
    std::thread::sleep(pause);
    let sent = Instant::now();
    process.signal(signal)?;
    let (code, said) = process.wait()?;
    let took = sent.elapsed();
    if code != Some(status) {
        return Err(format!("{signal}: it ended with {code:?}: {said}"));
    }
    let text = std::fs::read_to_string(trial.dir().join("summary.json")).map_err(|e| e.to_string())?;
    let summary: serde_json::Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let (done, kept) = (summary["speed"]["steps"].as_u64(), saved_step(&trial.dir())?);
    if done != kept || done.is_none() {
        return Err(format!("it did {done:?} steps, but its checkpoint has {kept:?}"));
    }
    let last = frames(&trial.dir())?.iter().map(|f| f.1).max();
    if last != done.map(|n| n - (n % 3).min(n % 10)) {
        return Err(format!("after {done:?} steps the last frame is at {last:?}"));
    }
    if took > LIMIT { Err(format!("it took {:.1} s", took.as_secs_f64())) } else { Ok(took) }
}

fn pressed(squirm: &Path, signal: &str, status: i32, pause: Duration) -> Result<Duration, String> {
    let trial = Trial::new(squirm, &ENDLESS)?;
    let process = trial.start()?;
    under_way(&trial)?;
    process.signal(signal)?;
    std::thread::sleep(pause / 50);
    let sent = Instant::now();
    process.signal(signal)?;
    let (code, said) = process.wait()?;
    if code != Some(status) {
        return Err(format!("{signal} twice: it ended with {code:?}: {said}"));
    }
    saved_step(&trial.dir())?.ok_or("there is no checkpoint")?;
    Ok(sent.elapsed())
}

//! kill -9 at random instants, and going on from what is there.

use super::child::Trial;
use super::record::{compare, left};
use super::table::Row;
use rand::{Rng, RngExt};
use squirm::checkpoint::{self, Damage};
use std::path::Path;
use std::time::Instant;

/// Times that one run is killed at most before it may end.
const MOST: u32 = 4;

/// Steps of the newest checkpoint of a directory; `None` if there is none yet.
pub fn saved_step(dir: &Path) -> Result<Option<u64>, String> {
    let step = |sections: &checkpoint::Sections| {
        let note: serde_json::Value = serde_json::from_slice(sections.get("run")?).unwrap_or_default();
        note["step"].as_u64().ok_or_else(|| Damage::Absent("step".into()))
    };
    Ok(checkpoint::load(dir, step).map_err(|e| e.to_string())?.map(|(step, _)| step))
}

/// Kills `count` runs, each a few times at random instants; then it ends as if nothing had happened.
pub fn kill(squirm: &Path, count: u32, random: &mut impl Rng) -> Result<Vec<Row>, String> {
    let undisturbed = Trial::new(squirm, &[])?;
    let began = Instant::now();
    undisturbed.finish()?;
    let mut whole = began.elapsed();
    let expected = left(&undisturbed.dir())?;
    let mut readable = Row::new("after kill -9 a checkpoint is there and can be read");
    let mut same = Row::new("killed runs that go on end in the same state, frames, tables and summary");
    let (mut late, mut steps) = (0, Vec::new());
    while same.trials < count {
        let trial = Trial::new(squirm, &[])?;
        let (mut going, mut kills) = (true, 0);
        for _ in 0..random.random_range(1..=MOST) {
            let process = trial.start()?;
            let pause = whole.mul_f64(random.random_range(0.0..1.0));
            std::thread::sleep(pause);
            going = process.kill()?;
            if !going {
                // A machine that was busy at first would make most instants too late.
                (late, whole) = (late + 1, whole.min(pause));
                break;
            }
            kills += 1;
            let step = saved_step(&trial.dir());
            steps.extend(step.iter().flatten().copied());
            // Before it has begun there is nothing to lose.
            readable.enter(step.map(drop));
        }
        if kills > 0 {
            let finished = if going { trial.finish() } else { Ok(()) };
            same.enter(finished.and_then(|()| compare(&left(&trial.dir())?, &expected)));
        }
    }
    steps.sort_unstable();
    let median = steps.get(steps.len() / 2).copied().unwrap_or(0);
    readable.figures = format!("steps kept: median {median}, from {:?} to {:?}", steps.first(), steps.last());
    same.figures = format!("{} frames in each; {late} runs were over before their kill", expected.frames.len());
    Ok(vec![readable, same])
}

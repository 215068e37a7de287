//! Readers that are stopped (SIGSTOP) for long: what the run loses by them, and what they see when they go on.

use super::child::{ENDLESS, Folder, Process, Trial};
use super::readers::{milliseconds, published, tap};
use super::table::Row;
use super::watcher::{Watcher, wait_for_readers, wait_until};
use squirm::wire::Kind;
use std::fs::File;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// How long a run waits for a stopped reader here, in seconds.
const LIMIT: f64 = 2.0;
/// What a machine may need besides.
const SLACK: Duration = Duration::from_secs(2);
/// Two runs that are compared take turns of this length.
const TURN: Duration = Duration::from_millis(500);
/// What a stopped reader may cost a run that does not wait, as a share of its speed.
const COST: f64 = 0.02;

/// Stops readers for `seconds` of a run's time.
pub fn stopped(squirm: &Path, seconds: u32) -> Result<Vec<Row>, String> {
    let mut speed =
        Row::new("on_slow = drop: a stopped reader costs under 2 % of the run's speed, or within 4 standard errors");
    let mut gaps = Row::new("once it goes on it gets snapshots again, and counts those that it has missed");
    let mut block =
        Row::new("on_slow = block: it costs the time limit once, and is waited for again when it has caught up");
    let mut abort = Row::new("on_slow = abort: the run ends with status 1 and the reason at the time limit");
    match dropping(squirm, seconds, &mut speed) {
        Ok(found) => gaps.tell(found),
        Err(why) => speed.enter(Err(why)),
    }
    block.tell(blocking(squirm, seconds));
    abort.tell(aborting(squirm).map(|took| format!("after {:.1} s", took.as_secs_f64())));
    Ok(vec![speed, gaps, block, abort])
}

/// Two runs take turns, so that each has the machine for itself: one with a stopped reader, one without.
fn dropping(squirm: &Path, seconds: u32, speed: &mut Row) -> Result<Result<String, String>, String> {
    let trials = [(); 2].map(|()| Trial::with(squirm, &published("drop", 1.0), &ENDLESS));
    let [first, second] = trials;
    let (first, second) = (first?, second?);
    let runs = [first.start()?, second.start()?];
    let watchers = [&first, &second].map(|trial| Watcher::attach(trial.name(), Kind::Scalars));
    let [a, b] = watchers;
    let mut watchers = [a?, b?];
    let folder = Folder::new()?;
    let out = folder.path().join("seen");
    let file = File::create(&out).map_err(|e| e.to_string())?;
    let mut reader = Process::start_into(Command::new(squirm).args(["tap", first.name(), "scalars", "--json"]), file)?;
    wait_for_readers(first.name(), Kind::Scalars, 2, &mut reader)?;
    wait_until("the reader prints nothing", || Ok(!numbers(&out)?.is_empty()))?;
    reader.signal("-STOP")?;
    let before = numbers(&out)?.len();
    for run in &runs {
        run.signal("-STOP")?;
    }
    let mut ratios = Vec::new();
    for number in 0..2 * seconds as usize {
        // Neither is always the first.
        let mut rates = [0.0; 2];
        for i in [number % 2, 1 - number % 2] {
            rates[i] = turn(&runs[i], &watchers[i])?;
        }
        ratios.push((rates[0] / rates[1]).ln());
    }
    for (run, watcher) in runs.iter().zip(&mut watchers) {
        run.signal("-CONT")?;
        watcher.next()?;
    }
    enter_speed(speed, &ratios);
    reader.signal("-CONT")?;
    wait_until("the reader gets nothing any more", || Ok(numbers(&out)?.len() > before + 10))?;
    reader.signal("-INT")?;
    let (_, said) = reader.wait()?;
    Ok(missed(&numbers(&out)?, &said))
}

/// Steps per second of a run that has been stopped and goes on for one turn.
#[allow(clippy::cast_precision_loss)]
fn turn(run: &Process, watcher: &Watcher) -> Result<f64, String> {
    let step = || watcher.last().map_or(0, |beat| beat.step);
    let before = step();
    run.signal("-CONT")?;
    let began = Instant::now();
    std::thread::sleep(TURN);
    run.signal("-STOP")?;
    let took = began.elapsed();
    // What is under way arrives.
    std::thread::sleep(Duration::from_millis(30));
    Ok((step() - before) as f64 / took.as_secs_f64())
}

#[allow(clippy::cast_precision_loss)]
fn enter_speed(row: &mut Row, ratios: &[f64]) {
    let n = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let error = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (n * (n - 1.0).max(1.0))).sqrt();
    let loss = -mean;
    let bearable = loss <= COST.max(4.0 * error);
    row.enter(if bearable { Ok(()) } else { Err(format!("it costs {:.1} %", 100.0 * loss)) });
    row.figures =
        format!("speed {:.3}({:.0}) of a run without, in {n} turns of 0.5 s each", mean.exp(), 1000.0 * error);
}

/// The numbers of the snapshots that a reader has printed.
fn numbers(path: &Path) -> Result<Vec<u64>, String> {
    let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    // The last line may not be whole yet.
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let number = |line: &str| {
        let value: serde_json::Value = serde_json::from_str(line).map_err(|e| format!("{line}: {e}"))?;
        value["seq"].as_u64().ok_or_else(|| format!("no number in {line}"))
    };
    whole.lines().map(number).collect()
}

fn missed(numbers: &[u64], said: &str) -> Result<String, String> {
    let gaps: u64 = numbers.windows(2).map(|w| w[1].saturating_sub(w[0] + 1)).sum();
    if gaps == 0 {
        return Err("it has missed nothing".into());
    }
    if !numbers.is_sorted() {
        return Err("its snapshots came out of order".into());
    }
    let told = format!("{gaps} snapshots passed unseen");
    if said.contains(&told) {
        Ok(format!("{gaps} missed, {} got", numbers.len()))
    } else {
        Err(format!("it missed {gaps} and said: {said}"))
    }
}

fn blocking(squirm: &Path, seconds: u32) -> Result<String, String> {
    let trial = Trial::with(squirm, &published("block", LIMIT), &ENDLESS)?;
    let run = trial.start()?;
    let mut statuses = Watcher::attach(trial.name(), Kind::Status)?;
    let mut reader = tap(squirm, trial.name(), &[])?;
    wait_for_readers(trial.name(), Kind::Scalars, 1, &mut reader)?;
    let before = statuses.next()?;
    reader.signal("-STOP")?;
    let stopped = Instant::now();
    // One wait, and what it takes to tell of it.
    std::thread::sleep(Duration::from_secs_f64(LIMIT) + 2 * SLACK);
    let waited = statuses.next()?;
    while stopped.elapsed() < Duration::from_secs(seconds.into()) {
        std::thread::sleep(Duration::from_millis(100));
    }
    let after = statuses.next()?;
    let longest = |from: Instant| statuses.beats().iter().filter(|b| b.at > from).map(|b| b.longest).max();
    let (once, again) = (longest(before.at).unwrap_or_default(), longest(waited.at).unwrap_or_default());
    if once.as_secs_f64() < LIMIT || once > Duration::from_secs_f64(LIMIT) + SLACK {
        return Err(format!("the run waited {} for it", milliseconds(once)));
    }
    if again.as_secs_f64() >= LIMIT {
        return Err(format!("and later {} once more", milliseconds(again)));
    }
    if after.dropped == before.dropped || after.step <= waited.step {
        return Err(format!("{} were lost to it, at step {}", after.dropped - before.dropped, after.step));
    }
    reader.signal("-CONT")?;
    let mut last = statuses.next()?;
    wait_until("it does not catch up", || {
        let now = statuses.next()?;
        let caught_up = now.dropped == last.dropped && now.step > last.step;
        last = now;
        Ok(caught_up)
    })?;
    reader.signal("-INT")?;
    reader.wait()?;
    run.signal("-INT")?;
    let (code, said) = run.wait()?;
    if code != Some(130) || !said.contains("goes on without it until it has caught up") {
        return Err(format!("the run ended with {code:?}: {said}"));
    }
    Ok(format!("waited {}, later {} at most; {} lost to it", milliseconds(once), milliseconds(again), last.dropped))
}

fn aborting(squirm: &Path) -> Result<Duration, String> {
    let trial = Trial::with(squirm, &published("abort", LIMIT), &ENDLESS)?;
    let run = trial.start()?;
    let _begun = Watcher::attach(trial.name(), Kind::Status)?;
    let mut reader = tap(squirm, trial.name(), &[])?;
    wait_for_readers(trial.name(), Kind::Scalars, 1, &mut reader)?;
    reader.signal("-STOP")?;
    let stopped = Instant::now();
    let (code, said) = run.wait()?;
    let took = stopped.elapsed();
    if code != Some(1) || !said.contains("a reader of scalars took no snapshot for 2 s") {
        return Err(format!("it ended with {code:?}: {said}"));
    }
    if took > Duration::from_secs_f64(LIMIT) + 2 * SLACK { Err(format!("after {took:?}")) } else { Ok(took) }
}

//! Readers that are killed while they read a run that goes: the run must not feel it.

use super::child::{ENDLESS, Folder, Process, Trial};
use super::table::Row;
use super::watcher::{Beat, Watcher, wait_for_readers};
use rand::{Rng, RngExt};
use squirm::wire::Kind;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// What a run may not stand still for because of a reader.
const STALL: Duration = Duration::from_millis(100);
/// What a run that waits for its readers may lose by one that is dead: it looks at silent readers every 0.1 s.
const NOTICED: Duration = Duration::from_secs(1);
/// Seconds after which readers that are not killed leave by themselves.
const STAY: f64 = 0.4;
/// What is looked at after a reader has gone belongs to it, too.
const AFTER: Duration = Duration::from_millis(100);

/// Outputs that any number of steps publish.
pub fn published(on_slow: &str, limit: f64) -> String {
    format!(
        "output = [{{ publish = [\"squirmers\", \"scalars\"], every = 2, on_slow = \"{on_slow}\", slow_limit = {limit:?} }}]\n\
         checkpoint = {{ enabled = false }}\n"
    )
}

/// Kills `count` readers of a run that waits for none, as many leave by themselves in between; then some of a run that waits.
pub fn readers(squirm: &Path, count: u32, random: &mut impl Rng) -> Result<Vec<Row>, String> {
    let mut rows = dropping(squirm, count, random)?;
    rows.push(blocking(squirm, count.div_ceil(4), random)?);
    Ok(rows)
}

/// A stretch of time that began and ended.
type Span = (Instant, Instant);

fn dropping(squirm: &Path, count: u32, random: &mut impl Rng) -> Result<Vec<Row>, String> {
    let trial = Trial::with(squirm, &published("drop", 1.0), &ENDLESS)?;
    let _run = trial.start()?;
    let (mut statuses, snapshots) =
        (Watcher::attach(trial.name(), Kind::Status)?, Watcher::attach(trial.name(), Kind::Scalars)?);
    let folder = Folder::new()?;
    let (mut killed, mut left): (Vec<Span>, Vec<Span>) = (Vec::new(), Vec::new());
    for number in 0..count {
        for kill in [number % 2 == 0, number % 2 != 0] {
            let began = Instant::now();
            let reader = reader(squirm, trial.name(), number, folder.path())?;
            if kill {
                // From its first instruction on, before and while it attaches, to the end of its life.
                std::thread::sleep(Duration::from_secs_f64(random.random_range(0.0..STAY)));
                reader.kill()?;
            } else {
                reader.wait()?;
            }
            // Whoever comes next clears up what the dead left. That is part of their going.
            drop(Watcher::attach(trial.name(), Kind::Status)?);
            std::thread::sleep(AFTER);
            if kill { &mut killed } else { &mut left }.push((began, Instant::now()));
        }
    }
    // The status of the last second.
    statuses.next()?;
    Ok(judge(&statuses.beats(), &snapshots.beats(), &killed, &left))
}

/// The books of the run first; then what a reader saw that stayed all the time.
fn judge(statuses: &[Beat], snapshots: &[Beat], killed: &[Span], left: &[Span]) -> Vec<Row> {
    let mut books =
        Row::new("on_slow = drop: while a reader is killed no publication takes over 0.1 s, by the run's own clock");
    let books_of = |spans: &[Span]| -> Vec<Vec<Duration>> {
        let of = |span: &Span| {
            // A status tells of the second before it.
            let first = statuses.iter().position(|b| b.at >= span.0).unwrap_or(statuses.len());
            let last = statuses.iter().position(|b| b.at >= span.1).unwrap_or(statuses.len().saturating_sub(1));
            statuses[first..=last.max(first).min(statuses.len() - 1)].iter().map(|b| b.longest).collect()
        };
        spans.iter().map(of).collect()
    };
    let with = books_of(killed);
    for times in &with {
        let longest = times.iter().max().copied().unwrap_or_default();
        books.enter(if longest <= STALL { Ok(()) } else { Err(format!("one took {}", milliseconds(longest))) });
    }
    let without = books_of(left);
    books.figures = format!(
        "longest {}; {} beside readers that leave by themselves",
        milliseconds(with.into_iter().flatten().max().unwrap_or_default()),
        milliseconds(without.into_iter().flatten().max().unwrap_or_default())
    );
    let (with, without) = (pauses(snapshots, killed), pauses(snapshots, left));
    let mut seen =
        Row::new("and another reader sees no more pauses over 0.1 s than beside readers that leave by themselves");
    let stalls = |pauses: &[Duration]| pauses.iter().filter(|p| **p > STALL).count();
    #[allow(clippy::cast_precision_loss)]
    let (a, b) = (stalls(&with) as f64, stalls(&without) as f64);
    // Counts of rare events: three standard deviations of their difference.
    let excess = (a - b) / (a + b).max(1.0).sqrt();
    seen.enter(if excess <= 3.0 { Ok(()) } else { Err(format!("{a} pauses over 0.1 s instead of {b}")) });
    let figures = |pauses: &[Duration]| {
        let n = stalls(pauses);
        format!(
            "median {}, 99.9 % below {}, longest {}, {n} over 0.1 s",
            milliseconds(quantile(pauses, 0.5)),
            milliseconds(quantile(pauses, 0.999)),
            milliseconds(quantile(pauses, 1.0))
        )
    };
    seen.figures = format!(
        "{} pauses with kills: {}; {} without: {}",
        with.len(),
        figures(&with),
        without.len(),
        figures(&without)
    );
    vec![books, seen]
}

/// Times between snapshots of which the later one came within one of the spans, sorted.
fn pauses(beats: &[Beat], spans: &[Span]) -> Vec<Duration> {
    let within = |at: Instant| spans.iter().any(|(began, ended)| at >= *began && at < *ended);
    let pairs = beats.windows(2).filter(|w| within(w[1].at));
    let mut pauses: Vec<Duration> = pairs.map(|w| w[1].at - w[0].at).collect();
    pauses.sort_unstable();
    pauses
}

/// The value below which this share of sorted ones lies.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn quantile(sorted: &[Duration], share: f64) -> Duration {
    let last = sorted.len().saturating_sub(1);
    sorted.get((last as f64 * share).round() as usize).copied().unwrap_or_default()
}

/// As people read it.
pub fn milliseconds(time: Duration) -> String {
    let value = time.as_secs_f64() * 1e3;
    if value < 10.0 { format!("{value:.2} ms") } else { format!("{value:.0} ms") }
}

/// `squirm tap` and `squirm-analyze` in turn.
fn reader(squirm: &Path, run: &str, number: u32, folder: &Path) -> Result<Process, String> {
    let stay = STAY.to_string();
    if number.is_multiple_of(2) {
        return tap(squirm, run, &["--for", &stay]);
    }
    let mut command = Command::new(squirm.with_file_name("squirm-analyze"));
    command.current_dir(folder).args(["swim", "--live", run, "--for", &stay, "--out", "swim"]);
    Process::start(&mut command)
}

/// A reader of the scalars.
pub fn tap(squirm: &Path, run: &str, more: &[&str]) -> Result<Process, String> {
    let mut command = Command::new(squirm);
    Process::start(command.args(["tap", run, "scalars"]).args(more))
}

fn blocking(squirm: &Path, count: u32, random: &mut impl Rng) -> Result<Row, String> {
    let mut row = Row::new("on_slow = block: a killed reader is noticed within 1 s, and the run goes on");
    let trial = Trial::with(squirm, &published("block", 60.0), &ENDLESS)?;
    let _run = trial.start()?;
    let mut statuses = Watcher::attach(trial.name(), Kind::Status)?;
    let mut all = Vec::new();
    for _ in 0..count {
        row.enter(noticed(squirm, trial.name(), &mut statuses, random).and_then(|took| {
            all.push(took);
            if took <= NOTICED { Ok(()) } else { Err(format!("after {}", milliseconds(took))) }
        }));
    }
    all.sort_unstable();
    row.figures = format!(
        "the run waited {} in the middle, {} at most; a stopped one would have cost 60 s",
        milliseconds(quantile(&all, 0.5)),
        milliseconds(quantile(&all, 1.0))
    );
    Ok(row)
}

/// How long the run waited for a reader that was killed.
fn noticed(squirm: &Path, run: &str, statuses: &mut Watcher, random: &mut impl Rng) -> Result<Duration, String> {
    let before = statuses.next()?;
    let mut tap = tap(squirm, run, &[])?;
    wait_for_readers(run, Kind::Scalars, 1, &mut tap)?;
    std::thread::sleep(Duration::from_millis(random.random_range(0..300)));
    let killed = Instant::now();
    tap.kill()?;
    // The run has to go on from where it was, and say so.
    let mut after = statuses.next()?;
    for _ in 0..2 {
        after = statuses.next()?;
    }
    if after.step <= before.step {
        return Err("the run stands still".into());
    }
    if after.dropped > before.dropped {
        return Err(format!(
            "{} snapshots were counted as lost, though the dead lose nothing",
            after.dropped - before.dropped
        ));
    }
    Ok(statuses.beats().iter().filter(|b| b.at >= killed).map(|b| b.longest).max().unwrap_or_default())
}

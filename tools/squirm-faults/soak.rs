//! A run that goes for long with all that a run can have: what it holds of the system must not grow.

use super::child::{Process, Trial};
use super::record::frames;
use super::table::Row;
use super::watcher::{Watcher, wait_until};
use rand::{Rng, RngExt};
use squirm::wire::Kind;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Everything at once: both recordings, a table, readers, checkpoints every few seconds.
const OUTPUTS: &str = r#"
output = [
    { publish = ["squirmers", "scalars"], record = ["squirmers", "scalars"], csv = ["scalars"], every = 500 },
    { publish = ["fields"], record = ["fields", "particles"], fraction = 0.1, every = 5000 },
]
checkpoint = { every = 10000 }
"#;
/// Nothing at all: what then grows is the driver's.
const BARE: &str = "checkpoint = { enabled = false }\n";
/// Steps of a run that is not over before the soak is, and whose books are those of a long one.
const LONG: [&str; 1] = ["run.steps=1000000000"];
/// After this time a run has let go of what it had for a reader that has gone: it looks five times a second.
const NOTICE: Duration = Duration::from_millis(600);
/// The run without outputs goes beside every so manieth reader.
const REST: u32 = 4;
/// Seconds that a reader stays.
const STAY: f64 = 4.0;
/// Stretches of the last half, whose means make the line.
const STRETCHES: usize = 10;
/// What memory may grow by in the last half: not more than can be seen, or this share of it.
const GROWTH: f64 = 0.01;

/// What a process holds at one moment.
#[derive(Debug, Clone, Copy, Default)]
struct Held {
    /// Seconds since the beginning.
    at: f64,
    /// Memory of its own, without files and shared memory, in bytes.
    own: f64,
    /// All of its memory that is present, in bytes.
    resident: f64,
    /// Open descriptors.
    descriptors: u64,
    /// Threads.
    threads: u64,
    /// Different files of /dev/shm that it has mapped.
    shared: u64,
}

/// Soaks for `minutes`.
pub fn soak(squirm: &Path, minutes: f64, random: &mut impl Rng) -> Result<Vec<Row>, String> {
    let (trial, bare) = (Trial::with(squirm, OUTPUTS, &LONG)?, Trial::with(squirm, BARE, &LONG)?);
    let (run, other) = (trial.start()?, bare.start()?);
    let mut statuses = Watcher::attach(trial.name(), Kind::Status)?;
    let before = everywhere();
    let begun = Instant::now();
    let (mut held, mut held_bare, mut readers, mut kills) = (Vec::new(), Vec::new(), 0_u32, 0);
    while begun.elapsed().as_secs_f64() < 60.0 * minutes {
        // The other run need not have as many steps.
        other.signal(if readers % REST == 0 { "-CONT" } else { "-STOP" })?;
        let mut reader = reader(squirm, &trial)?;
        readers += 1;
        if random.random_bool(0.5) {
            std::thread::sleep(Duration::from_secs_f64(random.random_range(0.0..STAY)));
            kills += u32::from(reader.kill()?);
        } else {
            wait_until("a reader does not leave", || reader.ended())?;
        }
        // Clears up what the dead left, as whoever comes next does; then all moments are alike.
        drop(Watcher::attach(trial.name(), Kind::Status)?);
        std::thread::sleep(NOTICE);
        let at = begun.elapsed().as_secs_f64();
        held.push(Held { at, ..look(run.id())? });
        held_bare.push(Held { at, ..look(other.id())? });
    }
    let steps = statuses.next()?.step;
    let after = everywhere();
    run.signal("-INT")?;
    let (code, said) = run.wait()?;
    let mut end = Row::new("it ends with its status and a complete recording");
    let recorded = frames(&trial.dir()).map(|frames| frames.len());
    let figures = format!("{steps} steps, {readers} readers, {kills} of them killed; {recorded:?} frames");
    end.enter(if code == Some(130) && recorded.is_ok() {
        Ok(())
    } else {
        Err(format!("{code:?}, {recorded:?}: {said}"))
    });
    end.figures = figures;
    let mut rows = judge(&held);
    let mut driver = memory("(the same of a run without outputs, readers and checkpoints)", &held_bare);
    // Told, not judged: it is what this machine's driver does.
    (driver.held, driver.failures) = (driver.trials, Vec::new());
    rows.push(driver);
    rows.push(end);
    rows[2].figures += &format!("; in all of /dev/shm {before} at first, {after} at the end");
    Ok(rows)
}

/// An analyzer with a growing memory of its own, attached to two topics.
fn reader(squirm: &Path, trial: &Trial) -> Result<Process, String> {
    let mut command = Command::new(squirm.with_file_name("squirm-analyze"));
    command.current_dir(trial.folder()).args(["swim", "--live", trial.name(), "--out", "swim"]);
    Process::start(command.args(["--for", &STAY.to_string()]))
}

/// Files in shared memory, whoever has made them.
fn everywhere() -> usize {
    std::fs::read_dir("/dev/shm").map_or(0, Iterator::count)
}

/// What a process holds now.
fn look(process: u32) -> Result<Held, String> {
    let folder = format!("/proc/{process}");
    let text =
        |name: &str| std::fs::read_to_string(format!("{folder}/{name}")).map_err(|e| format!("{folder}/{name}: {e}"));
    let status = text("status")?;
    let value = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        line.and_then(|rest| rest.split_whitespace().next()?.parse::<u32>().ok()).map_or(0.0, f64::from)
    };
    let maps = text("maps")?;
    let mut shared: Vec<&str> = maps
        .lines()
        .filter_map(|line| line.split_whitespace().nth(5))
        .filter(|path| path.starts_with("/dev/shm/"))
        .collect();
    shared.sort_unstable();
    shared.dedup();
    let descriptors = std::fs::read_dir(format!("{folder}/fd")).map_err(|e| format!("{folder}/fd: {e}"))?.count();
    let threads = std::fs::read_dir(format!("{folder}/task")).map_err(|e| format!("{folder}/task: {e}"))?.count();
    Ok(Held {
        at: 0.0,
        own: 1024.0 * value("RssAnon"),
        resident: 1024.0 * value("VmRSS"),
        descriptors: descriptors as u64,
        threads: threads as u64,
        shared: shared.len() as u64,
    })
}

fn judge(held: &[Held]) -> Vec<Row> {
    let counted = |claim, of: fn(&Held) -> u64| {
        let mut row = Row::new(claim);
        let (first, last) = held.split_at(held.len() / 2);
        let sorted = |part: &[Held]| {
            let mut counts: Vec<u64> = part.iter().map(of).collect();
            counts.sort_unstable();
            [0, counts.len() / 2, counts.len().saturating_sub(1)].map(|i| counts.get(i).copied().unwrap_or(0))
        };
        let (first, last) = (sorted(first), sorted(last));
        // The most is that of a moment at which something was still being let go of; a leak raises the least.
        let flat = last[0] <= first[0] && last[1] <= first[1];
        row.enter(if flat { Ok(()) } else { Err(format!("{first:?} at first, {last:?} later")) });
        let [least, middle, most] = first;
        row.figures =
            format!("{least}, {middle}, {most} in the first half, {}, {}, {} in the last", last[0], last[1], last[2]);
        row
    };
    vec![
        memory(
            "memory of the run's own is flat: its growth in the last half is within 3 standard errors, or under 1 %",
            held,
        ),
        counted(
            "open descriptors are no more in the last half than in the first (least and median judged; least, median, most)",
            |h| h.descriptors,
        ),
        counted("nor are files of shared memory", |h| h.shared),
        counted("nor are threads", |h| h.threads),
    ]
}

#[allow(clippy::cast_precision_loss)]
fn memory(claim: &'static str, held: &[Held]) -> Row {
    let mut row = Row::new(claim);
    let half = &held[held.len() / 2..];
    let Some((first, last)) = half.first().zip(half.last()).filter(|_| half.len() >= STRETCHES) else {
        row.enter(Err(format!("only {} samples: too few", held.len())));
        return row;
    };
    let (slope, error) = line(half);
    let (span, level) = (last.at - first.at, last.own);
    let (growth, uncertain) = (slope * span, error * span);
    let flat = growth <= 3.0 * uncertain || growth <= GROWTH * level;
    row.enter(if flat { Ok(()) } else { Err(format!("it grows by {:.0} bytes a second", slope)) });
    let mb = |bytes: f64| bytes / 1e6;
    row.figures = format!(
        "{:.2} MB ({:.1} MB resident); growth {:.3}({:.3}) MB in the last {:.1} minutes, {:.0} bytes a second; {} samples",
        mb(level),
        mb(last.resident),
        mb(growth),
        mb(uncertain),
        span / 60.0,
        slope,
        held.len()
    );
    row
}

/// Slope of memory in time and its standard error, from means over stretches: neighbouring samples are not independent.
#[allow(clippy::cast_precision_loss)]
fn line(held: &[Held]) -> (f64, f64) {
    let mean = |part: &[Held], of: fn(&Held) -> f64| part.iter().map(of).sum::<f64>() / part.len() as f64;
    let length = held.len() / STRETCHES;
    let points: Vec<(f64, f64)> =
        held.chunks_exact(length).take(STRETCHES).map(|part| (mean(part, |h| h.at), mean(part, |h| h.own))).collect();
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    let rest: f64 = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sum();
    (slope, (rest / ((n - 2.0) * spread)).sqrt())
}

//! Changed pipeline files: whatever is in them, checking ends soon, with a plan or with errors that have a place.

use super::child::Folder;
use super::mutations::Originals;
use super::table::Row;
use squirm::config::{load, meaning};
use squirm::diag::{Diagnostic, Sources};
use std::io::{BufRead, BufReader, Write};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

/// Longest time for one file; on a quiet machine the longest takes a tenth of a second.
const LIMIT: Duration = Duration::from_secs(10);
/// Address space of the process that checks, in kilobytes.
const SPACE: u32 = 2_000_000;
/// One copy of so many goes to `squirm check` itself.
const EVERY: u32 = 100;
/// Files that it gets at a time.
const BATCH: usize = 50;
/// Failures after which nothing new is to be learned.
const ENOUGH: usize = 20;

/// Checks `count` copies in a child process, which is started again when it dies.
pub fn pipelines(squirm: &Path, files: &Path, count: u32, seed: u64) -> Result<Vec<Row>, String> {
    let originals = Originals::new(files)?;
    let mut ends = Row::new("a changed pipeline file is checked without a panic, a crash, 2 GB of memory or 10 s");
    let mut places = Row::new("each of its errors has a place in the file and says what to do");
    let (mut next, mut crashes, mut told) = (0, 0, Told::default());
    while next < count && crashes < ENOUGH {
        let Some(why) = survey(files, seed, &mut next, count, &mut told)? else { break };
        crashes += 1;
        ends.enter(Err(format!("copy {next}: {why}")));
        next += 1;
    }
    for why in &told.bad {
        let panicked = why.contains(PANICKED);
        if panicked { &mut ends } else { &mut places }.enter(Err(why.clone()));
    }
    let good = |row: &mut Row, total: u32| {
        let good = total.saturating_sub(row.trials);
        (row.trials, row.held) = (row.trials + good, row.held + good);
    };
    good(&mut ends, next.min(count));
    good(&mut places, told.refused);
    ends.figures = format!(
        "copies of {} files; {} are refused, {} load; longest {:.0} ms (copy {})",
        originals.len(),
        told.refused,
        told.accepted,
        1e3 * told.longest.0,
        told.longest.1
    );
    places.figures = format!("{} errors and warnings", told.findings);
    Ok(vec![ends, places, commanded(squirm, &originals, seed, count)?])
}

/// What the processes that check have told.
#[derive(Default)]
struct Told {
    /// Copies that were refused, and that load.
    refused: u32,
    accepted: u32,
    findings: u64,
    /// The longest time in seconds, and the copy that took it.
    longest: (f64, u32),
    /// Copies that were not checked as they should be.
    bad: Vec<String>,
}

/// A process that does not outlive its owner.
struct Worker(Child);

impl Drop for Worker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Has copies checked from `next` on, which becomes the one that was being checked at the end; why the process died, if it did.
fn survey(files: &Path, seed: u64, next: &mut u32, count: u32, told: &mut Told) -> Result<Option<String>, String> {
    let me = std::env::current_exe().map_err(|e| e.to_string())?;
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {SPACE}; exec \"$0\" \"$@\"")]).arg(me);
    command.args([
        "pipelines",
        "--seed",
        &seed.to_string(),
        "--count",
        &count.to_string(),
        "--from",
        &next.to_string(),
    ]);
    command.arg("--files").arg(files).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut worker = Worker(command.spawn().map_err(|e| format!("sh does not start: {e}"))?);
    let lines = lines(worker.0.stdout.take().ok_or("no standard output")?);
    loop {
        match lines.recv_timeout(LIMIT) {
            Ok(line) => match line.split_once(' ') {
                None => *next = line.parse().map_err(|_| format!("what is `{line}`?"))?,
                Some(("bad", why)) => told.bad.push(why.into()),
                Some((_, numbers)) => told.add(numbers)?,
            },
            Err(RecvTimeoutError::Timeout) => return Ok(Some(format!("it takes over {} s", LIMIT.as_secs()))),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    let status = worker.0.wait().map_err(|e| e.to_string())?;
    if status.success() {
        *next = count;
        return Ok(None);
    }
    let mut said = String::new();
    if let Some(mut stderr) = worker.0.stderr.take() {
        let _ = std::io::Read::read_to_string(&mut stderr, &mut said);
    }
    Ok(Some(format!("{status}: {}", said.trim())))
}

impl Told {
    /// One line of sums: refused, accepted, findings, seconds.
    fn add(&mut self, numbers: &str) -> Result<(), String> {
        let wrong = || format!("what is `{numbers}`?");
        let values: Vec<f64> = numbers.split(' ').map(str::parse).collect::<Result<_, _>>().map_err(|_| wrong())?;
        let [number, refused, findings, seconds] = values[..] else { return Err(wrong()) };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let (number, findings) = (number as u32, findings as u64);
        *if refused == 0.0 { &mut self.accepted } else { &mut self.refused } += 1;
        self.findings += findings;
        if seconds > self.longest.0 {
            self.longest = (seconds, number);
        }
        Ok(())
    }
}

/// The lines of a process as they come.
fn lines(out: ChildStdout) -> Receiver<String> {
    let (send, lines) = sync_channel(1000);
    std::thread::spawn(move || BufReader::new(out).lines().map_while(Result::ok).try_for_each(|line| send.send(line)));
    lines
}

/// What the message of a copy that made the library panic begins with.
const PANICKED: &str = "it panicked";

/// The process that checks: prints the number of each copy before, and what came of it after.
pub fn work(files: &Path, seed: u64, numbers: Range<u32>) -> Result<Vec<Row>, String> {
    let originals = Originals::new(files)?;
    std::panic::set_hook(Box::new(|_| {}));
    let mut out = std::io::stdout().lock();
    for number in numbers {
        writeln!(out, "{number}").map_err(|e| e.to_string())?;
        let (path, bytes) = originals.changed(seed, number);
        let began = Instant::now();
        let checked = catch_unwind(AssertUnwindSafe(|| check(path, &bytes)));
        let took = began.elapsed().as_secs_f64();
        let told = match checked {
            Ok(Ok((refused, findings))) => format!("done {number} {} {findings} {took}", u8::from(refused)),
            Ok(Err(why)) => format!("bad copy {number}: {}", why.replace('\n', "\\n")),
            Err(panic) => {
                let said = panic.downcast_ref::<String>().map(String::as_str);
                let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("");
                format!("bad copy {number}: {PANICKED}: {}", said.replace('\n', "\\n"))
            }
        };
        writeln!(out, "{told}").map_err(|e| e.to_string())?;
    }
    // Nothing else may be printed.
    std::process::exit(0);
}

/// As `squirm check` does: whether it is refused, and how many findings there are, all of which have to be as they should.
fn check(path: &Path, bytes: &[u8]) -> Result<(bool, usize), String> {
    let text = String::from_utf8_lossy(bytes);
    match load("copy.toml", &text, &[], path.parent().unwrap_or(Path::new(""))) {
        Ok(loaded) => {
            loaded.warnings.iter().try_for_each(|found| placed(found, &loaded.sources))?;
            let text = meaning(&loaded).to_string();
            if text.is_empty() {
                return Err("it means nothing".into());
            }
            Ok((false, loaded.warnings.len()))
        }
        Err(failure) => {
            failure.diagnostics.iter().try_for_each(|found| placed(found, &failure.sources))?;
            if !failure.diagnostics.iter().any(Diagnostic::is_error) {
                return Err("it is refused without an error".into());
            }
            Ok((true, failure.diagnostics.len()))
        }
    }
}

/// Whether a finding says what, where and what to do.
fn placed(found: &Diagnostic, sources: &Sources) -> Result<(), String> {
    let line = || found.plain(sources).chars().take(300).collect::<String>();
    if found.message.is_empty() || found.help.as_ref().is_none_or(String::is_empty) {
        return Err(format!("no help: {}", line()));
    }
    if found.labels.is_empty() {
        return Err(format!("no place: {}", line()));
    }
    let there = |span: &squirm::diag::Span| {
        sources.get(span.source).is_some_and(|source| source.text.get(span.start..span.end).is_some())
    };
    match found.labels.iter().find(|(span, _)| !there(span)) {
        Some((span, _)) => Err(format!("{span:?} is no place: {}", line())),
        None => Ok(()),
    }
}

/// `squirm check` itself, with what it draws around errors.
fn commanded(squirm: &Path, originals: &Originals, seed: u64, count: u32) -> Result<Row, String> {
    let mut row = Row::new("squirm check prints what it finds, status 0 or 2");
    let folder = Folder::new()?;
    let numbers: Vec<u32> = (0..count).step_by(EVERY as usize).collect();
    for batch in numbers.chunks(BATCH) {
        let mut paths = Vec::new();
        for number in batch {
            let path = folder.path().join(format!("copy-{number}.toml"));
            std::fs::write(&path, originals.changed(seed, *number).1).map_err(|e| e.to_string())?;
            paths.push(path);
        }
        let status = |paths: &[std::path::PathBuf]| {
            let mut command = Command::new(squirm);
            command.arg("check").args(paths).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
            command.status().map_err(|e| e.to_string())
        };
        let fine = |status: std::process::ExitStatus| matches!(status.code(), Some(0 | 2));
        let all = fine(status(&paths)?);
        for path in &paths {
            let found = if all {
                Ok(())
            } else {
                status(std::slice::from_ref(path))
                    .and_then(|s| if fine(s) { Ok(()) } else { Err(format!("{s}: {}", path.display())) })
            };
            row.enter(found);
            std::fs::remove_file(path).map_err(|e| e.to_string())?;
        }
    }
    row.figures = format!("every {EVERY}th copy");
    Ok(row)
}

/// Prints one copy.
pub fn show(files: &Path, seed: u64, number: u32) -> Result<Vec<Row>, String> {
    let originals = Originals::new(files)?;
    std::io::stdout().write_all(&originals.changed(seed, number).1).map_err(|e| e.to_string())?;
    std::process::exit(0);
}

//! The analyzers of a pipeline file as processes: started with the run, started again when they die, ended with the run.
//!
//! A thread of its own looks after them: once it has begun the run never waits for one, nor ends because of one.

use crate::analyze::{self, kinds};
use crate::graph::AnalyzerProgram;
use crate::wire::Kind;
use std::collections::VecDeque;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long analyzers may take to write their reports after a run that has done all its steps.
pub const PATIENCE: Duration = Duration::from_secs(30);
/// The same after a run that was stopped or has failed.
pub const HASTE: Duration = Duration::from_secs(2);
/// How long an analyzer that was asked to end may take.
const GRACE: Duration = Duration::from_secs(1);
/// Longest time for which a run waits before its first step until its analyzers watch it, so that they see all of it.
const ATTACH: Duration = Duration::from_secs(5);
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(20);
/// An analyzer is started again after so long, and after so much more for every further death within [`WINDOW`].
const BACKOFF: Duration = Duration::from_millis(100);
/// Deaths are counted over so long.
const WINDOW: Duration = Duration::from_secs(60);
/// After more deaths than this within [`WINDOW`] an analyzer is given up.
const DEATHS: usize = 10;

/// The analyzers of one run. Dropped, they are ended in haste.
pub struct Analyzers {
    end: Option<SyncSender<Duration>>,
    thread: Option<JoinHandle<Vec<String>>>,
}

impl Analyzers {
    /// Starts the programs and waits shortly until those that are known watch the run. `out` is the run's folder, `run` its name; a
    /// run that cannot be watched has no analyzers.
    pub fn start(programs: &[AnalyzerProgram], out: &Path, run: Option<&str>) -> Self {
        let mut analyzers = Self { end: None, thread: None };
        let Some(run) = run.filter(|_| !programs.is_empty()) else { return analyzers };
        let mut all: Vec<Analyzer> = programs.iter().map(|p| Analyzer::new(p, out, run)).collect();
        all.iter_mut().for_each(Analyzer::spawn);
        let late = !attach(&mut all, run);
        let (end, ended) = sync_channel(1);
        let work = move || {
            let patience = loop {
                match ended.recv_timeout(LOOK) {
                    Ok(patience) => break patience,
                    Err(RecvTimeoutError::Disconnected) => break HASTE,
                    Err(RecvTimeoutError::Timeout) => all.iter_mut().for_each(Analyzer::look),
                }
            };
            finish(&mut all, patience);
            let late = late.then(|| "analyzers: they did not watch the run from its first step".to_owned());
            late.into_iter().chain(all.iter().filter_map(Analyzer::lost)).collect()
        };
        match std::thread::Builder::new().name("analyzers".into()).spawn(work) {
            Ok(thread) => (analyzers.end, analyzers.thread) = (Some(end), Some(thread)),
            Err(error) => tracing::warn!("nobody looks after the analyzers: {error}"),
        }
        analyzers
    }

    /// Waits until the analyzers have written their reports, which they do once the run's topics are closed. After `patience` they
    /// are asked to end, then killed. Says what of the run they have not seen.
    pub fn end(mut self, patience: Duration) -> Vec<String> {
        if let Some(end) = self.end.take() {
            let _ = end.send(patience);
        }
        self.thread.take().and_then(|thread| thread.join().ok()).unwrap_or_default()
    }
}

impl Drop for Analyzers {
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Waits until every topic has the readers that the known analyzers are, or one of them has died, but not long. Whether all are there;
/// of one that has died it is known anyway.
fn attach(all: &mut [Analyzer], run: &str) -> bool {
    let begun = Instant::now();
    let wanted = |topic: Kind| all.iter().filter(|a| a.topics.contains(&topic)).count();
    let wanted: Vec<(Kind, usize)> = Kind::ALL.into_iter().map(|k| (k, wanted(k))).filter(|(_, n)| *n > 0).collect();
    while all.iter_mut().all(Analyzer::is_alive) {
        let runs = analyze::running().unwrap_or_default();
        let topics = runs.iter().find(|r| r.name == run).map_or(&[][..], |r| &r.topics);
        if wanted.iter().all(|(kind, n)| topics.iter().any(|(k, readers)| k == kind && readers >= n)) {
            return true;
        }
        if begun.elapsed() >= ATTACH {
            return false;
        }
        std::thread::sleep(LOOK);
    }
    true
}

/// One analyzer.
struct Analyzer {
    name: String,
    command: Vec<String>,
    run: String,
    out: PathBuf,
    log: PathBuf,
    topics: &'static [Kind],
    /// It is one of squirm-analyze's.
    known: bool,
    child: Option<Child>,
    /// When it died lately.
    deaths: VecDeque<Instant>,
    /// When it is to be started again.
    again: Option<Instant>,
    /// How often it has died.
    died: u32,
    /// It has said that it missed snapshots.
    missed: bool,
}

impl Analyzer {
    fn new(program: &AnalyzerProgram, dir: &Path, run: &str) -> Self {
        // Programs may change their directory.
        let out = std::path::absolute(dir).unwrap_or_else(|_| dir.to_owned()).join(program.folder());
        let kind = program.kind.as_deref().and_then(kinds::find);
        let command = match (&program.command, kind) {
            (Some(words), _) => words.iter().map(|w| w.replace("{run}", run)).collect(),
            (None, Some(kind)) => {
                let folder = out.display().to_string();
                vec![beside("squirm-analyze"), kind.name.into(), "--live".into(), run.into(), "--out".into(), folder]
            }
            (None, None) => Vec::new(),
        };
        Self {
            name: program.name().into(),
            command,
            run: run.into(),
            log: out.with_added_extension("log"),
            out,
            topics: kind.map_or(&[], |k| k.topics),
            known: kind.is_some(),
            child: None,
            deaths: VecDeque::new(),
            again: None,
            died: 0,
            missed: false,
        }
    }

    /// Starts the process; a failure counts as a death.
    fn spawn(&mut self) {
        self.again = None;
        match self.started() {
            Ok(child) => self.child = Some(child),
            Err(error) => self.died(&format!("cannot be started: {error}")),
        }
    }

    fn started(&self) -> std::io::Result<Child> {
        if let Some(folder) = self.log.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let mut log = File::options().create(true).append(true).open(&self.log)?;
        writeln!(log, "# {}", self.command.join(" "))?;
        let (program, arguments) = self.command.split_first().ok_or(std::io::ErrorKind::InvalidInput)?;
        let mut command = Command::new(program);
        command.args(arguments).env("SQUIRM_RUN", &self.run).env("SQUIRM_OUT", &self.out);
        command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        // Ctrl-C is for the run, which then ends its analyzers when they have seen its last snapshot.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command.spawn()
    }

    /// Sees whether it has died, or is to be started again.
    fn look(&mut self) {
        match self.ended() {
            Some(Err(status)) => self.died(&format!("has died ({status})")),
            _ if self.again.is_some_and(|at| Instant::now() >= at) => self.spawn(),
            _ => {}
        }
    }

    /// How the process has ended, if it has, told once. One of ours that has only missed snapshots has not failed.
    fn ended(&mut self) -> Option<Result<(), ExitStatus>> {
        let status = self.child.as_mut()?.try_wait().ok().flatten()?;
        self.child = None;
        self.missed = self.known && status.code() == Some(analyze::DATA_LOST.into());
        Some(if status.success() || self.missed { Ok(()) } else { Err(status) })
    }

    /// What of the run it has not seen.
    fn lost(&self) -> Option<String> {
        let what = match (self.died, self.missed) {
            (0, false) => return None,
            (0, true) => "missed snapshots".to_owned(),
            (1, _) => "died once: its results are at most of the time since then".into(),
            (n, _) => format!("died {n} times: its results are at most of the time since then"),
        };
        Some(format!("the analyzer {} {what}; see {}", self.name, self.log.display()))
    }

    fn is_alive(&mut self) -> bool {
        self.look();
        self.child.is_some()
    }

    #[allow(clippy::cast_possible_truncation)]
    fn died(&mut self, how: &str) {
        self.died += 1;
        self.deaths.push_back(Instant::now());
        while self.deaths.front().is_some_and(|at| at.elapsed() > WINDOW) {
            self.deaths.pop_front();
        }
        let (name, log) = (&self.name, self.log.display());
        if self.deaths.len() > DEATHS {
            tracing::warn!(
                "the analyzer {name} {how}, {} times within a minute: the run goes on without it; see {log}",
                self.deaths.len()
            );
            return;
        }
        tracing::warn!("the analyzer {name} {how} and is started again; see {log}");
        self.again = Some(Instant::now() + BACKOFF * self.deaths.len() as u32);
    }
}

/// Waits for the processes, asks those that are left to end, then kills them.
fn finish(all: &mut [Analyzer], patience: Duration) {
    wait(all, patience);
    all.iter_mut().filter_map(|a| a.child.as_mut()).for_each(ask_to_end);
    wait(all, GRACE);
    for analyzer in all {
        if let Some(mut child) = analyzer.child.take() {
            // Its report has gone with it; a program of the user's may be made to go on for ever.
            analyzer.died += u32::from(analyzer.known);
            tracing::warn!("the analyzer {} did not end and was killed", analyzer.name);
            kill(&mut child);
            let _ = child.wait();
        }
    }
}

fn wait(all: &mut [Analyzer], patience: Duration) {
    let begun = Instant::now();
    loop {
        for analyzer in all.iter_mut() {
            if let Some(Err(status)) = analyzer.ended() {
                tracing::warn!("the analyzer {} ended with {status}; see {}", analyzer.name, analyzer.log.display());
            }
        }
        if all.iter().all(|a| a.child.is_none()) || begun.elapsed() >= patience {
            return;
        }
        std::thread::sleep(LOOK);
    }
}

#[cfg(unix)]
fn ask_to_end(child: &mut Child) {
    signal(child, libc::SIGTERM);
}

#[cfg(unix)]
fn kill(child: &mut Child) {
    signal(child, libc::SIGKILL);
}

/// Signals a process and those that it has started: its group is its own.
#[cfg(unix)]
fn signal(child: &Child, signal: i32) {
    if let Ok(id) = i32::try_from(child.id()) {
        // SAFETY: kill has no preconditions; the process is a child that nobody has waited for, so its number is not another's.
        #[allow(unsafe_code)]
        unsafe {
            libc::kill(-id, signal);
        }
    }
}

#[cfg(not(unix))]
fn ask_to_end(_child: &mut Child) {}

#[cfg(not(unix))]
fn kill(child: &mut Child) {
    // It may have ended this moment.
    let _ = child.kill();
}

/// A program that lies where this one lies, else by its name from the PATH.
fn beside(name: &str) -> String {
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let here = std::env::current_exe().ok().map(|own| own.with_file_name(&file));
    here.filter(|path| path.is_file()).map_or(file, |path| path.display().to_string())
}

//! Watching a run from outside while it goes: when its snapshots arrive, and what it says about itself.

use super::child::Process;
use squirm::analyze::{self, AnalyzeError, Limits, Live, Source};
use squirm::wire::{Kind, Status};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest wait for something that is to be seen of a run.
const PATIENCE: Duration = Duration::from_secs(120);

/// The arrival of one snapshot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beat {
    /// When.
    pub at: Instant,
    /// Its step.
    pub step: u64,
    /// Of a status: the longest that publishing one snapshot took since the status before.
    pub longest: Duration,
    /// Of a status: snapshots that could not be published, or that a reader missed although the run waited.
    pub dropped: u64,
}

/// A reader of one topic, in a thread of its own.
pub struct Watcher {
    stop: Arc<AtomicBool>,
    beats: Arc<Mutex<Vec<Beat>>>,
    thread: Option<JoinHandle<Option<String>>>,
}

impl Watcher {
    /// Attaches to a run, and waits for the first snapshot that it sees after a step. `kind` is the status, or what the run publishes.
    pub fn attach(run: &str, kind: Kind) -> Result<Self, String> {
        let (stop, beats) = (Arc::new(AtomicBool::new(false)), Arc::default());
        let limits = Limits { stop: Arc::clone(&stop), ..Limits::default() };
        let (mut live, seen) = (Live::new(run, limits), Arc::clone(&beats));
        let begun = Instant::now();
        let work = move || {
            loop {
                let ending = live.drive(&[kind], &mut |snapshot| {
                    let status = if kind == Kind::Status { Status::decode(snapshot)? } else { Status::default() };
                    let beat = Beat {
                        at: Instant::now(),
                        step: snapshot.header.step,
                        longest: Duration::try_from_secs_f64(status.longest_publication).unwrap_or_default(),
                        dropped: status.dropped,
                    };
                    all(&seen).push(beat);
                    Ok(ControlFlow::Continue(()))
                });
                // A run that has just been started is not there yet.
                match ending {
                    Err(AnalyzeError::NoRun { .. }) if begun.elapsed() < PATIENCE => {
                        std::thread::sleep(Duration::from_millis(20));
                    }
                    Err(why) => return Some(why.to_string()),
                    Ok(_) => return None,
                }
            }
        };
        let thread = std::thread::Builder::new().spawn(work).map_err(|e| e.to_string())?;
        let watcher = Self { stop, beats, thread: Some(thread) };
        wait_until("the run does not begin", || Ok(watcher.last().is_some_and(|beat| beat.step > 0)))?;
        Ok(watcher)
    }

    /// All arrivals so far.
    pub fn beats(&self) -> Vec<Beat> {
        all(&self.beats).clone()
    }

    /// The newest.
    pub fn last(&self) -> Option<Beat> {
        all(&self.beats).last().copied()
    }

    /// Waits for one that comes after now.
    pub fn next(&mut self) -> Result<Beat, String> {
        let now = Instant::now();
        wait_until("the run says nothing any more", || {
            if let Some(thread) = self.thread.take_if(|thread| thread.is_finished()) {
                let why = thread.join().ok().flatten().unwrap_or_else(|| "the run has ended".into());
                return Err(format!("the watcher has stopped: {why}"));
            }
            Ok(self.last().is_some_and(|beat| beat.at > now))
        })?;
        self.last().ok_or_else(|| "nothing has come".into())
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn all(beats: &Mutex<Vec<Beat>>) -> MutexGuard<'_, Vec<Beat>> {
    beats.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until something holds.
pub fn wait_until(otherwise: &str, mut holds: impl FnMut() -> Result<bool, String>) -> Result<(), String> {
    let begun = Instant::now();
    while !holds()? {
        if begun.elapsed() > PATIENCE {
            return Err(otherwise.into());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Ok(())
}

/// Waits until a topic of a run has so many readers, or the newest of them has ended.
pub fn wait_for_readers(run: &str, kind: Kind, count: usize, newest: &mut Process) -> Result<(), String> {
    wait_until("the reader does not come", || {
        let runs = analyze::running().map_err(|e| e.to_string())?;
        let topics = runs.iter().find(|r| r.name == run).map_or(&[][..], |r| &r.topics);
        Ok(topics.iter().any(|(k, readers)| *k == kind && *readers >= count) || newest.ended()?)
    })
}

//! When checkpoints are due, and writing them on a thread of their own.

use super::outputs::{Marking, Marks};
use super::saved::Draft;
use super::{RunError, faults};
use crate::graph::Checkpoints;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Writes a run's checkpoints.
pub struct Keeper {
    dir: PathBuf,
    enabled: bool,
    interval: Duration,
    every: u64,
    last: Instant,
    took: Duration,
    job: Option<JoinHandle<Result<Duration, RunError>>>,
}

impl Keeper {
    /// For a run in `dir` that begins or goes on now.
    pub fn new(dir: &Path, settings: &Checkpoints) -> Self {
        let seconds = 60.0 * settings.minutes;
        Self {
            dir: dir.into(),
            enabled: settings.enabled,
            interval: if seconds > 0.0 { Duration::from_secs_f64(seconds) } else { Duration::MAX },
            every: if settings.every == 0 { u64::MAX } else { settings.every },
            last: Instant::now(),
            took: Duration::ZERO,
            job: None,
        }
    }

    /// Whether the run writes checkpoints at all.
    pub fn enabled(&self) -> bool {
        self.enabled
    }

    /// The next step after `step` at which one is due by steps.
    pub fn next_due(&self, step: u64) -> u64 {
        step.checked_next_multiple_of(self.every)
            .map_or(u64::MAX, |n| if n == step { n.saturating_add(self.every) } else { n })
    }

    /// Whether one is due after `step` steps. While one is still being written no other is.
    pub fn due(&self, step: u64) -> bool {
        let writing = self.job.as_ref().is_some_and(|job| !job.is_finished());
        self.enabled && !writing && (step.is_multiple_of(self.every) || self.last.elapsed() >= self.interval)
    }

    /// The longest that writing one has taken.
    pub fn took(&self) -> Duration {
        self.took
    }

    /// Writes one at once.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&mut self, draft: &Draft, marks: &Marks) -> Result<(), RunError> {
        let began = Instant::now();
        draft.write(&self.dir, marks)?;
        self.took = began.elapsed();
        Ok(())
    }

    /// Begins to write one, as soon as what the outputs had by then is on the disk.
    ///
    /// # Errors
    /// If the one before could not be written, or the system has no thread left.
    pub fn begin(&mut self, draft: Draft, marking: Marking) -> Result<(), RunError> {
        self.settle()?;
        self.last = Instant::now();
        let dir = self.dir.clone();
        let write = move || {
            let began = Instant::now();
            // A state that would stop the run is not worth keeping.
            faults::finite(draft.note.step, &draft.buffers)?;
            // Outputs that have failed tell the step loop why.
            if let Some(marks) = marking.wait() {
                draft.write(&dir, &marks)?;
            }
            Ok(began.elapsed())
        };
        let failed = |source| RunError::File { what: "start a thread for", path: self.dir.clone(), source };
        self.job = Some(std::thread::Builder::new().name("checkpoint".into()).spawn(write).map_err(failed)?);
        Ok(())
    }

    /// Waits until the last one is on the disk.
    ///
    /// # Errors
    /// If it could not be written.
    pub fn settle(&mut self) -> Result<(), RunError> {
        if let Some(job) = self.job.take() {
            let panicked = |_| RunError::File {
                what: "write a checkpoint into",
                path: self.dir.clone(),
                source: std::io::Error::other("its thread has ended"),
            };
            self.took = self.took.max(job.join().map_err(panicked)??);
        }
        Ok(())
    }

    /// Notices a failure of the last one, if it is over.
    ///
    /// # Errors
    /// If it could not be written.
    pub fn glance(&mut self) -> Result<(), RunError> {
        if self.job.as_ref().is_some_and(JoinHandle::is_finished) { self.settle() } else { Ok(()) }
    }
}

impl Drop for Keeper {
    /// A run that fails still lets its last checkpoint become complete.
    fn drop(&mut self) {
        let _ = self.settle();
    }
}

//! What a run tells about itself: a status about once a second, from a thread of its own, so that it comes whatever the outputs do.

use super::{Publisher, SinkError};
use crate::wire::{Kind, Stamp, Status};
use std::collections::VecDeque;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two statuses.
const EVERY: Duration = Duration::from_secs(1);
/// Longest time for which a newcomer waits for the last one.
const WELCOME: Duration = Duration::from_millis(200);
/// The speed is a mean over so long.
const WINDOW: Duration = Duration::from_secs(5);
/// Runs of one name that can go at once.
const NAMESAKES: u32 = 100;

/// The present state of a run; its thread works the speed out.
#[derive(Debug, Clone, Default)]
pub struct Now {
    /// Identity, step, time and box; the count is the thread's.
    pub stamp: Stamp,
    /// The rest.
    pub status: Status,
}

/// Publishes the status of a run until it is dropped, and holds the run's name.
pub struct Beacon {
    name: String,
    now: Arc<Mutex<Now>>,
    end: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Beacon {
    /// Takes the name `name`, or `name-2`, `name-3` and so on while other runs of this user have it, and begins to publish.
    ///
    /// # Errors
    /// If shared memory cannot be used.
    pub fn light(name: &str, now: Now) -> Result<Self, SinkError> {
        let mut publisher = None;
        for number in 1..=NAMESAKES {
            let candidate = if number == 1 { name.to_owned() } else { format!("{name}-{number}") };
            match Publisher::open(&candidate, &[(Kind::Status, Status::message_bytes())]) {
                Err(SinkError::Taken(_)) => {}
                opened => {
                    publisher = Some((candidate, opened?));
                    break;
                }
            }
        }
        let (name, publisher) = publisher.ok_or_else(|| SinkError::Taken(name.into()))?;
        let now = Arc::new(Mutex::new(now));
        let (end, ended) = sync_channel(0);
        let shared = now.clone();
        let work = move || {
            let mut light = Light { publisher, shared, sequence: 0, past: VecDeque::new() };
            light.shine();
            let mut last = Instant::now();
            while ended.recv_timeout(WELCOME) == Err(RecvTimeoutError::Timeout) {
                if last.elapsed() >= EVERY {
                    last = Instant::now();
                    light.shine();
                } else {
                    light.publisher.welcome();
                }
            }
            light.shine();
        };
        let thread = std::thread::Builder::new().name("status".into()).spawn(work);
        let thread = thread.map_err(|e| SinkError::Ipc {
            what: "start a thread for the status",
            name: name.clone(),
            reason: e.to_string(),
        })?;
        Ok(Self { name, now, end: Some(end), thread: Some(thread) })
    }

    /// The name under which the run is known.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What will be told next; to be held shortly.
    pub fn now(&self) -> MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Beacon {
    /// Publishes the last state, then gives the name back.
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the thread has.
struct Light {
    publisher: Publisher,
    shared: Arc<Mutex<Now>>,
    sequence: u64,
    past: VecDeque<(Instant, u64)>,
}

impl Light {
    fn shine(&mut self) {
        let mut now = {
            let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
            let now = shared.clone();
            // The next status tells of the time from here on.
            shared.status.longest_publication = 0.0;
            now
        };
        self.past.push_back((Instant::now(), now.stamp.step));
        while self.past.len() > 2 && self.past[0].0.elapsed() > WINDOW {
            self.past.pop_front();
        }
        now.stamp.seq = self.sequence;
        now.status.speed = speed(&self.past);
        self.sequence += 1;
        if let Err(e) = self.publisher.publish(&now.status.encode(&now.stamp)) {
            tracing::warn!(reason = %e, "the status of the run was not published");
        }
    }
}

/// Steps per second between the first and the last entry.
#[allow(clippy::cast_precision_loss)]
fn speed(past: &VecDeque<(Instant, u64)>) -> f64 {
    match (past.front(), past.back()) {
        (Some((begin, first)), Some((end, last))) if end > begin => {
            last.saturating_sub(*first) as f64 / (*end - *begin).as_secs_f64()
        }
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_is_that_between_the_ends_of_the_window() {
        let begin = Instant::now();
        let at = |s: u64| begin + Duration::from_secs(s);
        assert_eq!(speed(&VecDeque::from([(at(0), 100), (at(1), 160), (at(4), 300)])), 50.0);
        assert_eq!(speed(&VecDeque::from([(at(0), 100)])), 0.0);
        assert_eq!(speed(&VecDeque::from([(at(0), 100), (at(1), 50)])), 0.0, "a replay that was wound back");
    }
}

//! Readers that are slower than the run: how long it waits for each, and when it stops waiting.

use crate::wire::domain;
use iceoryx2::node::{Node, NodeState, NodeView};
use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::{CallbackProgression, ipc_threadsafe};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What becomes of a snapshot for which a reader has no room yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OnSlow {
    /// The reader loses its oldest snapshot; the run never waits.
    #[default]
    Drop,
    /// The run waits so long; then the reader loses this snapshot, and the run waits for it no more until it has caught up.
    Block(Duration),
    /// The run waits so long; then it ends.
    Abort(Duration),
}

impl OnSlow {
    /// How long the run may wait for one reader; `None` where it never does.
    #[must_use]
    pub fn limit(self) -> Option<Duration> {
        match self {
            Self::Drop => None,
            Self::Block(limit) | Self::Abort(limit) => Some(limit),
        }
    }
}

/// Time between two looks at a queue that is full.
const NAP: Duration = Duration::from_millis(2);
/// A reader that keeps the run waiting for so long is looked at: the dead need not be waited for.
const LOOK: Duration = Duration::from_millis(100);

/// How one message fared with the readers that were slow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Verdict {
    /// Readers that used up the limit with this message.
    pub late: usize,
    /// Readers that did not get it.
    pub missed: usize,
    /// Some reader's process is dead and may be cleaned up.
    pub dead: bool,
}

/// What one topic knows of its slow readers. Asked from inside a send, whose port must not be touched meanwhile.
pub(super) struct Patience {
    limit: Duration,
    /// Ends every wait.
    pub hurry: AtomicBool,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Readers and their nodes, as of the beginning of the send.
    readers: Vec<(u128, u128)>,
    /// Readers that have used up the limit and not caught up since.
    given_up: Vec<u128>,
    /// Readers that had no room for the present message at first.
    slow: Vec<u128>,
    looked: Option<Instant>,
    verdict: Verdict,
}

impl Patience {
    pub fn new(limit: Duration) -> Self {
        Self { limit, hurry: AtomicBool::new(false), state: Mutex::default() }
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// A message is about to be sent to these readers.
    pub fn begin(&self, readers: Vec<(u128, u128)>) {
        let mut state = self.state();
        state.readers = readers;
        state.slow.clear();
        state.verdict = Verdict::default();
    }

    /// The message has been sent: readers that had room have caught up.
    pub fn end(&self) -> Verdict {
        let mut state = self.state();
        let State { given_up, slow, .. } = &mut *state;
        given_up.retain(|id| slow.contains(id));
        state.verdict
    }

    /// What to do about a reader whose queue is full.
    pub fn ask(&self, info: &BackpressureInfo) -> BackpressureAction {
        let id = info.receiver_port_id;
        let mut state = self.state();
        if !state.slow.contains(&id) {
            state.slow.push(id);
        }
        let known = state.given_up.contains(&id);
        let late = !known && info.elapsed_time >= self.limit;
        let dead = !known && !late && state.is_dead(id, info.elapsed_time);
        if known || late || dead || self.hurry.load(Ordering::Relaxed) {
            state.verdict.late += usize::from(late);
            state.verdict.missed += usize::from(!dead);
            if !known {
                state.given_up.push(id);
            }
            return BackpressureAction::DiscardData;
        }
        drop(state);
        std::thread::sleep(NAP);
        BackpressureAction::Retry
    }
}

impl State {
    /// Whether the reader's process has gone without a word; looked at now and then only.
    fn is_dead(&mut self, reader: u128, waited: Duration) -> bool {
        let due = waited >= LOOK && self.looked.is_none_or(|at| at.elapsed() >= LOOK);
        let node = self.readers.iter().find(|(id, _)| *id == reader).map(|(_, node)| *node);
        let (true, Some(node), Ok(config)) = (due, node, domain::config()) else { return false };
        self.looked = Some(Instant::now());
        let mut dead = false;
        // A listing that fails says nothing about the reader; the limit still holds.
        let _ = Node::<ipc_threadsafe::Service>::list(&config, |state| {
            dead |= matches!(&state, NodeState::Dead(view) if view.id().value() == node);
            if dead { CallbackProgression::Stop } else { CallbackProgression::Continue }
        });
        self.verdict.dead |= dead;
        dead
    }
}

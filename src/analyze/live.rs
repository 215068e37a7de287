//! Snapshots out of a run that is going, through shared memory.

use super::{AnalyzeError, Ending, Source, Visit};
use crate::wire::domain::{self, Block};
use crate::wire::{Header, Kind, Snapshot, WireError};
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{
    CallbackProgression, Config, LogLevel, Node, NodeBuilder, PortFactory, Service as _, SignalHandlingMode, ipc,
    set_log_level,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as Factory;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

type Service = ipc::Service;

/// How often a waiting source looks for a publisher that was killed: nobody tells it otherwise.
const LOOK_FOR_DEAD: Duration = Duration::from_secs(1);
/// Longest sleep: after it the limits and the stop flag are looked at again.
const NAP: Duration = Duration::from_millis(100);
/// Longest sleep on one of several topics: the others wake nobody meanwhile, and their buffers are short.
const SHARED_NAP: Duration = Duration::from_millis(1);

/// Shared memory that one subscriber needs at most; where there is less, its first message would kill it.
const ROOM: u64 = 1 << 18;

/// When to stop although the run goes on.
#[derive(Debug, Clone, Default)]
pub struct Limits {
    /// After this time.
    pub duration: Option<Duration>,
    /// After this many snapshots.
    pub snapshots: Option<u64>,
    /// When this becomes true.
    pub stop: Arc<AtomicBool>,
}

/// A live run on this machine.
#[derive(Debug, Clone)]
pub struct Live {
    run: String,
    limits: Limits,
}

impl Live {
    /// The run of this name.
    #[must_use]
    pub fn new(run: &str, limits: Limits) -> Self {
        Self { run: run.into(), limits }
    }
}

/// One topic.
struct Topic {
    kind: Kind,
    service: Factory<Service, [Block], Header>,
    subscriber: Subscriber<Service, [Block], Header>,
    listener: Listener<Service>,
    expected: Option<u64>,
    /// Messages that were no snapshots of this topic, and why the first was not.
    refused: Option<(u64, WireError)>,
}

impl Source for Live {
    fn offers(&self, topic: Kind) -> bool {
        runs(topic).is_ok_and(|runs| runs.contains(&self.run))
    }

    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError> {
        set_log_level(LogLevel::Error);
        let config = config()?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Service>()
            .map_err(|e| failed("join the shared-memory domain", &e))?;
        let mut topics =
            topics.iter().map(|k| Topic::open(&node, &config, &self.run, *k)).collect::<Result<Vec<_>, _>>()?;
        let (begin, mut looked, mut ending) = (Instant::now(), Instant::now(), Ending::default());
        loop {
            // Asked before the last samples are taken, so that none sent before the end is missed.
            let over = topics.iter().all(|t| t.service.dynamic_config().number_of_publishers() == 0);
            for topic in &mut topics {
                if topic.drain(&self.limits, &mut ending, visit)? {
                    return Ok(ended(ending, &topics));
                }
            }
            if over || self.limits.passed(begin) {
                break;
            }
            let longest = if topics.len() > 1 { SHARED_NAP } else { NAP };
            let nap = self.limits.nap(begin).min(longest);
            for topic in &topics {
                match topic.listener.timed_wait(|_| {}, nap) {
                    // A reader that was stopped and goes on, too: signals that are to end it set a limit.
                    Ok(_) | Err(ListenerWaitError::InterruptSignal) => {}
                    Err(e) => return Err(failed("wait for snapshots", &e)),
                }
            }
            if looked.elapsed() > LOOK_FOR_DEAD {
                looked = Instant::now();
                node.try_cleanup_dead_nodes();
            }
        }
        Ok(ended(ending, &topics))
    }
}

/// What the user should know of the end.
fn ended(mut ending: Ending, topics: &[Topic]) -> Ending {
    if ending.lost > 0 {
        let lost = ending.lost;
        let why = "the run publishes faster than this analyzer reads";
        ending.warnings.push(format!("{lost} snapshots passed unseen: {why}"));
    }
    for (topic, (count, why)) in topics.iter().filter_map(|t| Some((t.kind.topic(), t.refused.as_ref()?))) {
        ending.warnings.push(format!("{count} messages on {topic} were skipped: {why}"));
    }
    ending
}

impl Limits {
    fn passed(&self, begin: Instant) -> bool {
        self.stop.load(Ordering::Relaxed) || self.duration.is_some_and(|d| begin.elapsed() >= d)
    }

    fn nap(&self, begin: Instant) -> Duration {
        self.duration.map_or(NAP, |d| NAP.min(d.saturating_sub(begin.elapsed())))
    }
}

impl Topic {
    fn open(node: &Node<Service>, config: &Config, run: &str, kind: Kind) -> Result<Self, AnalyzeError> {
        if let Some(free) = domain::free().filter(|free| *free < ROOM) {
            let reason = format!("{free} bytes are free in {}, {ROOM} are needed", domain::MEMORY);
            return Err(AnalyzeError::Ipc { what: "connect to a run: shared memory is full", reason });
        }
        let name = domain::service(run, kind.topic()).map_err(|e| failed("name a service", &e))?;
        let service = node.service_builder(&name).publish_subscribe::<[Block]>().user_header::<Header>().open();
        let absent = || {
            let publishes = |k: &Kind| *k != Kind::Status && list(config, *k).iter().any(|name| name == run);
            let own = Kind::ALL.into_iter().filter(publishes).map(Kind::topic).collect();
            AnalyzeError::NoRun { run: run.into(), topic: kind.topic(), own, live: list(config, kind) }
        };
        let service = service.map_err(|e| match e {
            PublishSubscribeOpenError::DoesNotExist | PublishSubscribeOpenError::IsMarkedForDestruction => absent(),
            e => failed("open the run's service (was it made by another version of squirm?)", &e),
        })?;
        if service.dynamic_config().number_of_publishers() == 0 {
            return Err(absent());
        }
        let events =
            node.service_builder(&name).event().open().map_err(|e| failed("open the run's event service", &e))?;
        let listener = events.listener_builder().create().map_err(|e| failed("open a listener", &e))?;
        let subscriber = service.subscriber_builder().history_request(1).create();
        let subscriber = subscriber.map_err(|e| failed("subscribe (do too many analyzers read this run?)", &e))?;
        Ok(Self { kind, service, subscriber, listener, expected: None, refused: None })
    }

    /// Takes what has arrived; says whether that was all that is wanted.
    fn drain(&mut self, limits: &Limits, ending: &mut Ending, visit: &mut Visit<'_>) -> Result<bool, AnalyzeError> {
        while let Some(sample) = self.subscriber.receive().map_err(|e| failed("receive a snapshot", &e))? {
            let parsed = Snapshot::parse(bytemuck::cast_slice(sample.payload()));
            let snapshot = match parsed.and_then(|s| s.expect(self.kind).map(|()| s)) {
                Ok(snapshot) => snapshot,
                Err(why) => {
                    let (count, first) = self.refused.take().unwrap_or((0, why));
                    self.refused = Some((count + 1, first));
                    continue;
                }
            };
            let seq = snapshot.header.seq;
            let lost = self.expected.map_or(0, |expected| seq.saturating_sub(expected));
            ending.lost = ending.lost.saturating_add(lost);
            self.expected = Some(seq.saturating_add(1));
            ending.snapshots += 1;
            if visit(&snapshot)?.is_break() || limits.snapshots.is_some_and(|n| ending.snapshots >= n) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

fn failed(what: &'static str, reason: &dyn std::fmt::Debug) -> AnalyzeError {
    AnalyzeError::Ipc { what, reason: format!("{reason:?}") }
}

fn config() -> Result<Config, AnalyzeError> {
    domain::config().map_err(|e| failed("name the shared-memory domain", &e))
}

/// A run that is going on this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Running {
    /// Its name.
    pub name: String,
    /// Its topics, and how many subscribers each has.
    pub topics: Vec<(Kind, usize)>,
}

/// The runs of this user that are going, by name.
///
/// # Errors
/// If the shared-memory domain cannot be joined.
pub fn running() -> Result<Vec<Running>, AnalyzeError> {
    set_log_level(LogLevel::Error);
    let config = config()?;
    let node = NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Service>()
        .map_err(|e| failed("join the shared-memory domain", &e))?;
    // Runs that were killed are none.
    node.try_cleanup_dead_nodes();
    let mut runs: Vec<Running> = Vec::new();
    for kind in Kind::ALL {
        for name in list(&config, kind) {
            let Ok(service) = domain::service(&name, kind.topic()) else { continue };
            // A run may end between the listing and here.
            let Ok(topic) =
                node.service_builder(&service).publish_subscribe::<[Block]>().user_header::<Header>().open()
            else {
                continue;
            };
            if topic.dynamic_config().number_of_publishers() == 0 {
                continue;
            }
            let entry = (kind, topic.dynamic_config().number_of_subscribers());
            match runs.iter_mut().find(|r| r.name == name) {
                Some(run) => run.topics.push(entry),
                None => runs.push(Running { name, topics: vec![entry] }),
            }
        }
    }
    runs.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(runs)
}

/// Names of the runs of this user that publish `kind` now.
///
/// # Errors
/// If the directory for temporary files has a name that a shared-memory domain cannot have.
pub fn runs(kind: Kind) -> Result<Vec<String>, AnalyzeError> {
    Ok(list(&config()?, kind))
}

/// A listing that fails midway lists what it saw.
fn list(config: &Config, kind: Kind) -> Vec<String> {
    let mut names = Vec::new();
    let _ = Service::list(config, |service| {
        if let Some(run) = domain::run_of(service.static_details.name().as_str(), kind.topic()) {
            names.push(run.to_owned());
        }
        CallbackProgression::Continue
    });
    names.sort();
    names.dedup();
    names
}

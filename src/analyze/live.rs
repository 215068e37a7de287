//! Snapshots out of a run that is going, through shared memory.

use super::{AnalyzeError, Ending, Source, Visit};
use crate::wire::domain::{self, Block};
use crate::wire::{Header, Kind, Snapshot};
use iceoryx2::port::listener::Listener;
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
    service: Factory<Service, [Block], Header>,
    subscriber: Subscriber<Service, [Block], Header>,
    listener: Listener<Service>,
    expected: Option<u64>,
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
                    return Ok(ending);
                }
            }
            if over || self.limits.passed(begin) {
                break;
            }
            let longest = if topics.len() > 1 { SHARED_NAP } else { NAP };
            let nap = self.limits.nap(begin).min(longest);
            for topic in &topics {
                topic.listener.timed_wait(|_| {}, nap).map_err(|e| failed("wait for snapshots", &e))?;
            }
            if looked.elapsed() > LOOK_FOR_DEAD {
                looked = Instant::now();
                node.try_cleanup_dead_nodes();
            }
        }
        if ending.lost > 0 {
            let lost = ending.lost;
            ending
                .warnings
                .push(format!("{lost} snapshots passed unseen: the run publishes faster than this analyzer reads"));
        }
        Ok(ending)
    }
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
        let name = domain::service(run, kind.topic()).map_err(|e| failed("name a service", &e))?;
        let service = node.service_builder(&name).publish_subscribe::<[Block]>().user_header::<Header>().open();
        let absent = || AnalyzeError::NoRun { run: run.into(), topic: kind.topic(), live: list(config, kind) };
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
        Ok(Self { service, subscriber, listener, expected: None })
    }

    /// Takes what has arrived; says whether that was all that is wanted.
    fn drain(&mut self, limits: &Limits, ending: &mut Ending, visit: &mut Visit<'_>) -> Result<bool, AnalyzeError> {
        while let Some(sample) = self.subscriber.receive().map_err(|e| failed("receive a snapshot", &e))? {
            let snapshot = Snapshot::parse(bytemuck::cast_slice(sample.payload()))?;
            let seq = snapshot.header.seq;
            ending.lost += self.expected.map_or(0, |expected| seq.saturating_sub(expected));
            self.expected = Some(seq + 1);
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

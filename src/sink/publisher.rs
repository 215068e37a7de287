//! Publishing snapshots through shared memory: a slow, stopped or killed reader never holds the run up.

use super::SinkError;
use crate::wire::domain::{self, Block};
use crate::wire::{Header, Kind};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher as Port;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::{
    AllocationStrategy, EventId, LogLevel, Node, NodeBuilder, SignalHandlingMode, ipc_threadsafe, set_log_level,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

type Service = ipc_threadsafe::Service;

/// Bytes that a topic needs besides its samples: queues, connections, events, and the rest of the last page.
const MANAGEMENT: u64 = 1 << 18;

/// Time between two looks at a reader without room.
const NAP: Duration = Duration::from_millis(1);

/// Publishes the topics of one run; may move to another thread.
pub struct Publisher {
    topics: Vec<Topic>,
    dropped: u64,
    // Declared last: ports close before the node that owns them.
    node: Node<Service>,
}

struct Topic {
    kind: Kind,
    max: usize,
    port: Port<Service, [Block], Header>,
    notifier: Notifier<Service>,
    /// Messages that a reader missed although they waited for it.
    missed: Arc<AtomicU64>,
}

impl Publisher {
    /// Opens one service per topic, each for messages up to the given length.
    ///
    /// # Errors
    /// If shared memory is too small, the name is taken, or iceoryx2 refuses.
    pub fn open(run: &str, topics: &[(Kind, usize)]) -> Result<Self, SinkError> {
        Self::with(run, topics, None)
    }

    /// As [`Publisher::open`], for what need not keep pace: a message waits until every reader has room for it, each reader at most
    /// `limit` once. One that took longer is not waited for again.
    ///
    /// # Errors
    /// As for [`Publisher::open`].
    pub fn patient(run: &str, topics: &[(Kind, usize)], limit: Duration) -> Result<Self, SinkError> {
        Self::with(run, topics, Some(limit))
    }

    fn with(run: &str, topics: &[(Kind, usize)], limit: Option<Duration>) -> Result<Self, SinkError> {
        set_log_level(LogLevel::Error);
        check_space(topics, samples(limit))?;
        let failed = |what, reason: String| SinkError::Ipc { what, name: run.into(), reason };
        let config = domain::config().map_err(|e| failed("name the shared-memory domain", format!("{e:?}")))?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Service>()
            .map_err(|e| {
                failed("join the shared-memory domain", format!("{e:?}; who owns {}?", config.global.root_path()))
            })?;
        // What killed runs left behind would otherwise count against the limits below.
        node.try_cleanup_dead_nodes();
        let topics =
            topics.iter().map(|(kind, max)| Topic::open(&node, run, (*kind, *max), limit)).collect::<Result<_, _>>()?;
        Ok(Self { topics, dropped: 0, node })
    }

    /// Publishes one message; returns how many subscribers it reached. A message that
    /// cannot be delivered is dropped and counted.
    ///
    /// # Errors
    /// If the bytes are no snapshot, the topic was not opened, or the message is longer than announced.
    pub fn publish(&mut self, bytes: &[u8]) -> Result<usize, SinkError> {
        let header = crate::wire::Snapshot::parse(bytes)?.header;
        let kind = header.kind()?;
        let topic = self.topics.iter().find(|t| t.kind == kind).ok_or(SinkError::NotOpen(kind.topic()))?;
        if bytes.len() > topic.max {
            return Err(SinkError::TooLong { topic: kind.topic(), bytes: bytes.len(), max: topic.max });
        }
        // Messages are a multiple of a block long.
        let blocks = bytes.as_chunks::<16>().0;
        let Ok(mut sample) = topic.port.loan_slice_uninit(blocks.len()) else {
            self.dropped += 1;
            return Ok(0);
        };
        *sample.user_header_mut() = header;
        let missed = topic.missed.load(Ordering::Relaxed);
        // A run must not end because of those who watch it.
        let reached = sample.write_from_fn(|i| Block(blocks[i])).send().unwrap_or_else(|e| {
            tracing::warn!(topic = kind.topic(), reason = ?e, "a snapshot was not published");
            self.dropped += 1;
            0
        });
        if let Err(e) = topic.notifier.notify() {
            tracing::warn!(topic = kind.topic(), reason = ?e, "subscribers were not woken; they look by themselves later");
        }
        if topic.missed.load(Ordering::Relaxed) > missed {
            // It may have been killed; then it is not to be asked again.
            self.node.try_cleanup_dead_nodes();
        }
        Ok(reached)
    }

    /// Gives subscribers that came since the last message the newest one now; otherwise they get it with the next.
    pub fn welcome(&self) {
        for topic in &self.topics {
            if let Err(e) = topic.port.update_connections() {
                tracing::warn!(topic = topic.kind.topic(), reason = ?e, "new subscribers wait for the next snapshot");
            }
        }
    }

    /// Messages dropped so far.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped + self.topics.iter().map(|t| t.missed.load(Ordering::Relaxed)).sum::<u64>()
    }
}

impl Topic {
    fn open(node: &Node<Service>, run: &str, topic: (Kind, usize), limit: Option<Duration>) -> Result<Self, SinkError> {
        let ((kind, max), samples) = (topic, samples(limit));
        let failed = |what, reason: String| SinkError::Ipc { what, name: format!("{run}/{}", kind.topic()), reason };
        let name = domain::service(run, kind.topic()).map_err(|e| failed("name a service", format!("{e:?}")))?;
        let service = node
            .service_builder(&name)
            .publish_subscribe::<[Block]>()
            .user_header::<Header>()
            .max_publishers(1)
            .max_subscribers(domain::MAX_SUBSCRIBERS)
            .history_size(1)
            .subscriber_max_buffer_size(domain::BUFFER)
            .subscriber_max_borrowed_samples(domain::MAX_BORROWED)
            .enable_safe_overflow(limit.is_none())
            .open_or_create()
            .map_err(|e| match e {
                // Left open by subscribers of an earlier run with other limits.
                PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(e) => {
                    failed("open a service that subscribers of an earlier run still hold", format!("{e:?}"))
                }
                e => failed("open a service", format!("{e:?}")),
            })?;
        let events = node
            .service_builder(&name)
            .event()
            .notifier_dropped_event(EventId::new(domain::EVENT_CLOSED))
            .notifier_dead_event(EventId::new(domain::EVENT_DIED))
            .open_or_create()
            .map_err(|e| failed("open an event service", format!("{e:?}")))?;
        let notifier = events
            .notifier_builder()
            .default_event_id(EventId::new(domain::EVENT_SENT))
            .create()
            .map_err(|e| failed("open a notifier", format!("{e:?}")))?;
        let missed = Arc::new(AtomicU64::new(0));
        let port = service
            .publisher_builder()
            .initial_max_slice_len(max.div_ceil(size_of::<Block>()))
            .allocation_strategy(AllocationStrategy::Static)
            // All of them once, to touch them; then one at a time.
            .max_loaned_samples(samples)
            .override_sample_preallocation(move |worst| worst.min(samples))
            .set_backpressure_handler(waiting(limit.unwrap_or_default(), missed.clone()))
            .create()
            .map_err(|e| match e {
                iceoryx2::port::publisher::PublisherCreateError::ExceedsMaxSupportedPublishers => {
                    SinkError::Taken(run.into())
                }
                e => failed("open a publisher", format!("{e:?}")),
            })?;
        touch(&port, max, samples).map_err(|e| failed("set memory aside", e))?;
        Ok(Self { kind, max, port, notifier, missed })
    }
}

/// Samples for which memory is set aside. Readers that are waited for may each hold others.
fn samples(limit: Option<Duration>) -> usize {
    let waiting = domain::MAX_SUBSCRIBERS * (domain::MAX_BORROWED + domain::BUFFER) + 2;
    if limit.is_none() { domain::SAMPLES } else { waiting }
}

/// What to do about a reader without room: wait, but never for one that is stopped or dead for good.
fn waiting(limit: Duration, missed: Arc<AtomicU64>) -> impl Fn(&BackpressureInfo) -> BackpressureAction + Send + Sync {
    let given_up = Mutex::new(Vec::new());
    move |info| {
        let mut given_up = given_up.lock().unwrap_or_else(PoisonError::into_inner);
        if !given_up.contains(&info.receiver_port_id) {
            if info.elapsed_time < limit {
                drop(given_up);
                std::thread::sleep(NAP);
                return BackpressureAction::Retry;
            }
            given_up.push(info.receiver_port_id);
        }
        missed.fetch_add(1, Ordering::Relaxed);
        BackpressureAction::DiscardData
    }
}

/// Writes to every sample, so that the system sets its memory aside now, while [`check_space`] has just found it free: a page
/// that first turns out to be missing at hour nine would kill the run.
fn touch(port: &Port<Service, [Block], Header>, max: usize, samples: usize) -> Result<(), String> {
    let mut held = Vec::with_capacity(samples);
    for _ in 0..samples {
        let sample = port.loan_slice_uninit(max.div_ceil(size_of::<Block>())).map_err(|e| format!("{e:?}"))?;
        held.push(sample.write_from_fn(|_| Block([0; 16])));
    }
    Ok(())
}

/// Memory is only set aside when it is first written to, and a write that finds none kills the process: see [`touch`].
fn check_space(topics: &[(Kind, usize)], samples: usize) -> Result<(), SinkError> {
    let path = Path::new("/dev/shm");
    let Some(free) = free(path) else { return Ok(()) };
    let need = |max: usize| (max as u64).saturating_mul(samples as u64).saturating_add(MANAGEMENT);
    let need = topics.iter().map(|(_, max)| need(*max)).fold(0, u64::saturating_add);
    if need <= free {
        return Ok(());
    }
    let topics = topics.iter().map(|(kind, _)| kind.topic().to_owned()).collect();
    Err(SinkError::SharedMemory { path: PathBuf::from(path), topics, need, free })
}

/// Bytes free at `path`; `None` where the system keeps shared memory elsewhere.
#[cfg(unix)]
fn free(path: &Path) -> Option<u64> {
    use std::os::unix::ffi::OsStrExt;
    let path = std::ffi::CString::new(path.as_os_str().as_bytes()).ok()?;
    // SAFETY: `path` ends with a zero byte, and `stat` is a plain structure that statvfs fills.
    #[allow(unsafe_code)]
    let (status, stat) = unsafe {
        let mut stat: libc::statvfs = std::mem::zeroed();
        (libc::statvfs(path.as_ptr(), &raw mut stat), stat)
    };
    #[allow(clippy::unnecessary_cast)]
    (status == 0).then(|| (stat.f_bavail as u64).saturating_mul(stat.f_frsize as u64))
}

#[cfg(not(unix))]
fn free(_path: &Path) -> Option<u64> {
    None
}

//! Publishing snapshots through shared memory: a slow, stopped or killed reader never holds the run up longer than its output allows.

use super::SinkError;
use super::memory;
use super::patience::{OnSlow, Patience};
use crate::wire::domain::{self, Block};
use crate::wire::{Header, Kind};
use iceoryx2::port::backpressure_strategy::BackpressureStrategy;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher as Port, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{
    AllocationStrategy, CallbackProgression, EventId, LogLevel, Node, NodeBuilder, PortFactory as _,
    SignalHandlingMode, ipc_threadsafe, set_log_level,
};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as Factory;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

type Service = ipc_threadsafe::Service;

/// A topic to publish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Offer {
    /// What its messages hold.
    pub kind: Kind,
    /// Length of the longest message in bytes.
    pub max: usize,
    /// What becomes of a message that a reader has no room for.
    pub on_slow: OnSlow,
}

impl Offer {
    /// Samples for which memory is set aside.
    #[must_use]
    pub fn samples(&self) -> usize {
        match (self.kind, self.on_slow) {
            (Kind::Status, _) => domain::SAMPLES_STATUS,
            (_, OnSlow::Drop) => domain::SAMPLES,
            _ => domain::SAMPLES_WAITING,
        }
    }

    fn subscribers(&self) -> usize {
        if self.kind == Kind::Status { domain::MAX_WATCHERS } else { domain::MAX_SUBSCRIBERS }
    }
}

/// What became of messages so far; may be read from another thread.
#[derive(Debug, Default)]
pub struct Counters {
    published: AtomicU64,
    dropped: AtomicU64,
    /// Nanoseconds that the longest publication took since somebody asked.
    longest: AtomicU64,
}

impl Counters {
    /// Messages published.
    #[must_use]
    pub fn published(&self) -> u64 {
        self.published.load(Ordering::Relaxed)
    }

    /// Messages that could not be published, or that a reader missed although the run waited for it.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// The longest that publishing a message, or welcoming new subscribers, has taken since this was last asked.
    #[must_use]
    pub fn take_longest(&self) -> Duration {
        Duration::from_nanos(self.longest.swap(0, Ordering::Relaxed))
    }

    fn took(&self, time: Duration) {
        self.longest.fetch_max(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
}

/// Publishes the topics of one run; may move to another thread.
pub struct Publisher {
    topics: Vec<Topic>,
    counters: Arc<Counters>,
    starved: bool,
    // Declared last: ports close before the node that owns them.
    node: Node<Service>,
}

struct Topic {
    offer: Offer,
    // Closes before the service whose readers it serves.
    port: Port<Service, [Block], Header>,
    notifier: Notifier<Service>,
    service: Factory<Service, [Block], Header>,
    patience: Option<Arc<Patience>>,
    /// Messages that were not published, and those that a reader missed.
    dropped: u64,
}

impl Publisher {
    /// Opens one service per topic, each for messages up to the given length, and never waits for a reader.
    ///
    /// # Errors
    /// As for [`Publisher::offer`].
    pub fn open(run: &str, topics: &[(Kind, usize)]) -> Result<Self, SinkError> {
        let offer = |(kind, max): &(Kind, usize)| Offer { kind: *kind, max: *max, on_slow: OnSlow::Drop };
        Self::offer(run, &topics.iter().map(offer).collect::<Vec<_>>())
    }

    /// Opens one service per topic.
    ///
    /// # Errors
    /// If shared memory is too small, the name is taken, or iceoryx2 refuses.
    pub fn offer(run: &str, offers: &[Offer]) -> Result<Self, SinkError> {
        set_log_level(LogLevel::Error);
        memory::check_space(offers)?;
        let failed = |what, reason: String| SinkError::Ipc { what, name: run.into(), reason };
        let config = domain::config().map_err(|e| failed("name the shared-memory domain", format!("{e:?}")))?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Service>()
            .map_err(|e| {
                failed(
                    "join the shared-memory domain",
                    format!("{e:?}; {} and {} must be yours to write", config.global.root_path(), domain::MEMORY),
                )
            })?;
        // What killed runs left behind would otherwise count against the limits below.
        node.try_cleanup_dead_nodes();
        let topics = offers.iter().map(|offer| Topic::open(&node, run, offer)).collect::<Result<_, _>>()?;
        Ok(Self { topics, counters: Arc::default(), starved: false, node })
    }

    /// Publishes one message; returns how many subscribers it reached. A message that cannot be delivered is dropped and counted.
    ///
    /// # Errors
    /// If the bytes are no snapshot, the topic was not opened, the message is longer than announced, or a reader was slower than
    /// [`OnSlow::Abort`] allows.
    pub fn publish(&mut self, bytes: &[u8]) -> Result<usize, SinkError> {
        let began = Instant::now();
        let reached = self.send(bytes);
        self.counters.took(began.elapsed());
        reached
    }

    fn send(&mut self, bytes: &[u8]) -> Result<usize, SinkError> {
        let header = crate::wire::Snapshot::parse(bytes)?.header;
        let kind = header.kind()?;
        let index = self.topics.iter().position(|t| t.offer.kind == kind).ok_or(SinkError::NotOpen(kind.topic()))?;
        let max = self.topics[index].offer.max;
        if bytes.len() > max {
            return Err(SinkError::TooLong { topic: kind.topic(), bytes: bytes.len(), max });
        }
        if self.is_starved() {
            self.drop_of(index, 1);
            return Ok(0);
        }
        let topic = &self.topics[index];
        // Messages are a multiple of a block long.
        let blocks = bytes.as_chunks::<16>().0;
        let Ok(mut sample) = topic.port.loan_slice_uninit(blocks.len()) else {
            self.drop_of(index, 1);
            return Ok(0);
        };
        *sample.user_header_mut() = header;
        topic.announce();
        // A run must not end because of those who watch it.
        let sent = sample.write_from_fn(|i| Block(blocks[i])).send();
        let reached = sent.unwrap_or_else(|e| {
            tracing::warn!(topic = kind.topic(), reason = ?e, "a snapshot was not published");
            self.drop_of(index, 1);
            0
        });
        let topic = &self.topics[index];
        self.counters.published.fetch_add(1, Ordering::Relaxed);
        if let Err(e) = topic.notifier.notify() {
            tracing::warn!(topic = kind.topic(), reason = ?e, "subscribers were not woken; they look by themselves later");
        }
        self.judge(index)?;
        Ok(reached)
    }

    /// Draws the consequences of what the last message had to wait for.
    fn judge(&mut self, index: usize) -> Result<(), SinkError> {
        let Topic { offer, patience: Some(patience), .. } = &self.topics[index] else { return Ok(()) };
        let (offer, verdict) = (*offer, patience.end());
        self.drop_of(index, verdict.missed as u64);
        if verdict.dead {
            self.node.try_cleanup_dead_nodes();
        }
        let (topic, limit) = (offer.kind.topic(), offer.on_slow.limit().unwrap_or_default());
        if verdict.late == 0 {
            return Ok(());
        }
        if matches!(offer.on_slow, OnSlow::Abort(_)) {
            return Err(SinkError::SlowReader { topic, limit });
        }
        tracing::warn!(
            "a reader of {topic} took no snapshot for {} s: the run goes on without it until it has caught up",
            limit.as_secs_f64()
        );
        Ok(())
    }

    fn drop_of(&mut self, index: usize, messages: u64) {
        self.topics[index].dropped += messages;
        self.counters.dropped.fetch_add(messages, Ordering::Relaxed);
    }

    /// Gives subscribers that came since the last message the newest one now; otherwise they get it with the next.
    pub fn welcome(&mut self) {
        if self.is_starved() {
            return;
        }
        let began = Instant::now();
        for topic in &self.topics {
            if let Err(e) = topic.port.update_connections() {
                tracing::warn!(topic = topic.offer.kind.topic(), reason = ?e, "new subscribers wait for the next snapshot");
            }
        }
        self.counters.took(began.elapsed());
    }

    /// Whether shared memory is so full that connecting to a new reader could kill the run.
    fn is_starved(&mut self) -> bool {
        let starved = !memory::room();
        if starved && !self.starved {
            tracing::warn!("shared memory ({}) is full: nothing is published until there is room", domain::MEMORY);
        }
        self.starved = starved;
        starved
    }

    /// Ends every wait for a reader, also one that is going on, from now on.
    #[must_use]
    pub fn hurrier(&self) -> Box<dyn Fn() + Send + Sync> {
        let all: Vec<Arc<Patience>> = self.topics.iter().filter_map(|t| t.patience.clone()).collect();
        Box::new(move || all.iter().for_each(|p| p.hurry.store(true, Ordering::Relaxed)))
    }

    /// What became of the messages, for those who want to look while the publisher works elsewhere.
    #[must_use]
    pub fn counters(&self) -> Arc<Counters> {
        self.counters.clone()
    }

    /// Messages dropped so far.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.counters.dropped()
    }

    /// Those of topics that wait for their readers, so that none was to be lost; topics without losses are left out.
    #[must_use]
    pub fn lost(&self) -> Vec<(Kind, u64)> {
        let waits = |t: &&Topic| t.offer.on_slow != OnSlow::Drop && t.dropped > 0;
        self.topics.iter().filter(waits).map(|t| (t.offer.kind, t.dropped)).collect()
    }
}

impl Topic {
    fn open(node: &Node<Service>, run: &str, offer: &Offer) -> Result<Self, SinkError> {
        let topic = offer.kind.topic();
        let failed = |what, reason: String| SinkError::Ipc { what, name: format!("{run}/{topic}"), reason };
        let name = domain::service(run, topic).map_err(|e| failed("name a service", format!("{e:?}")))?;
        let service = node
            .service_builder(&name)
            .publish_subscribe::<[Block]>()
            .user_header::<Header>()
            .max_publishers(1)
            .max_subscribers(offer.subscribers())
            .history_size(1)
            .subscriber_max_buffer_size(domain::BUFFER)
            .subscriber_max_borrowed_samples(domain::MAX_BORROWED)
            .enable_safe_overflow(offer.on_slow == OnSlow::Drop)
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
        let patience = offer.on_slow.limit().map(|limit| Arc::new(Patience::new(limit)));
        let samples = offer.samples();
        let builder = service
            .publisher_builder()
            .initial_max_slice_len(offer.max.div_ceil(size_of::<Block>()))
            .allocation_strategy(AllocationStrategy::Static)
            // All of them once, to set them aside; then one at a time.
            .max_loaned_samples(samples)
            .override_sample_preallocation(move |worst| worst.min(samples))
            .backpressure_strategy(BackpressureStrategy::DiscardData);
        let builder = match patience.clone() {
            Some(patience) => builder.set_backpressure_handler(move |i| patience.ask(i)),
            None => builder,
        };
        let port = builder.create().map_err(|e| match e {
            PublisherCreateError::ExceedsMaxSupportedPublishers => SinkError::Taken(run.into()),
            e => failed("open a publisher", format!("{e:?}")),
        })?;
        let mut held = Vec::with_capacity(samples);
        for _ in 0..samples {
            let sample = port.loan_slice_uninit(offer.max.div_ceil(size_of::<Block>()));
            let mut sample = sample.map_err(|e| failed("set memory aside", format!("{e:?}")))?;
            memory::set_aside(offer, sample.payload_mut())?;
            held.push(sample);
        }
        drop(held);
        Ok(Self { offer: *offer, port, notifier, service, patience, dropped: 0 })
    }

    /// Tells the one who may have to wait who the readers are.
    fn announce(&self) {
        let Some(patience) = &self.patience else { return };
        let mut readers = Vec::new();
        self.service.dynamic_config().list_subscribers(|reader| {
            readers.push((reader.subscriber_id.value(), reader.node_id.value()));
            CallbackProgression::Continue
        });
        patience.begin(readers);
    }
}

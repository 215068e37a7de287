//! Where snapshots go: recordings (MCAP), analyzers on this machine (shared memory), and tables (CSV).
//!
//! All of them take the same encoded messages; [`Outlets`] hands one message to those that asked for it, and
//! [`Writer`] does so on a thread of its own.

mod beacon;
mod cut;
mod memory;
mod outlets;
mod patience;
mod publisher;
mod recorder;
mod scene;
mod slice;
mod tables;
mod track;

pub use beacon::{Beacon, Now};
pub use outlets::{Job, Kept, Outlets, Summary, Targets, Writer};
pub use patience::OnSlow;
pub use publisher::{Counters, Offer, Publisher};
pub use recorder::{Durable, FileInfo, Part, Provenance, Recorder};
pub use tables::{Rows, Tables};

use crate::wire::WireError;
use std::path::PathBuf;

/// Why a snapshot could not be delivered.
#[derive(Debug, thiserror::Error)]
pub enum SinkError {
    /// An output file that must not be overwritten.
    #[error("{} exists already: choose another output directory, or remove it", .0.display())]
    Exists(PathBuf),
    /// No space left on the device.
    #[error("disk full while writing {}: what was written before can be read", .0.display())]
    DiskFull(PathBuf),
    /// Any other failure to write.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The recording's own rules were broken.
    #[error("cannot record into {}: {source}", path.display())]
    Mcap {
        /// The file.
        path: PathBuf,
        /// What the writer said.
        source: mcap::McapError,
    },
    /// A recording has lost messages that it had at the checkpoint.
    #[error(
        "{} has {found} whole messages, but had {wanted} at the checkpoint{}: put the file back as it was, or begin anew with --fresh",
        path.display(), source.as_ref().map_or_else(String::new, |e| format!(" ({e})"))
    )]
    Shortened {
        /// The file.
        path: PathBuf,
        /// Messages that can be read.
        found: u64,
        /// Messages at the checkpoint.
        wanted: u64,
        /// Where reading ended.
        source: Option<mcap::McapError>,
    },
    /// A table has lost rows that it had at the checkpoint.
    #[error(
        "{} has {found} bytes, but had {wanted} at the checkpoint: put the file back as it was, or begin anew with --fresh",
        path.display()
    )]
    Torn {
        /// The file.
        path: PathBuf,
        /// Its length.
        found: u64,
        /// Its length at the checkpoint.
        wanted: u64,
    },
    /// The message is not a snapshot.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// Shared memory is too small; writing to it would kill the process.
    #[error(
        "shared memory is too small: publishing {} needs {need} bytes in {}, {free} are free; \
         enlarge it (docker run --shm-size), publish a smaller fraction, publish less, or write live = false under [run]",
        topics.join(", "),
        path.display()
    )]
    SharedMemory {
        /// Where shared memory lives.
        path: PathBuf,
        /// What is to be published.
        topics: Vec<String>,
        /// Bytes needed at worst.
        need: u64,
        /// Bytes free.
        free: u64,
    },
    /// A reader was slower than an output with `on_slow = "abort"` allows.
    #[error(
        "a reader of {topic} took no snapshot for {} s, and its output says on_slow = \"abort\"; what was recorded is complete",
        limit.as_secs_f64()
    )]
    SlowReader {
        /// Topic.
        topic: &'static str,
        /// How long the run waited.
        limit: std::time::Duration,
    },
    /// Another process publishes under this name.
    #[error("a run named `{0}` is already publishing: give one of the two another name")]
    Taken(String),
    /// iceoryx2 refused.
    #[error("cannot {what} for `{name}`: {reason}")]
    Ipc {
        /// What was attempted.
        what: &'static str,
        /// Run or service.
        name: String,
        /// What iceoryx2 said.
        reason: String,
    },
    /// A message longer than announced.
    #[error("a {topic} snapshot of {bytes} bytes exceeds the {max} bytes announced for its topic")]
    TooLong {
        /// Topic.
        topic: &'static str,
        /// Length of the message.
        bytes: usize,
        /// Announced length.
        max: usize,
    },
    /// A message for a topic that was not opened.
    #[error("topic {0} was not opened for publishing")]
    NotOpen(&'static str),
    /// The thread that writes has ended, and has said why before, or panicked.
    #[error("the writer thread has ended")]
    Ended,
}

impl SinkError {
    /// Sorts a system error: a full disk is named as such.
    fn io(path: &std::path::Path, source: std::io::Error) -> Self {
        match source.kind() {
            std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => Self::DiskFull(path.into()),
            std::io::ErrorKind::AlreadyExists => Self::Exists(path.into()),
            _ => Self::Io { path: path.into(), source },
        }
    }

    fn mcap(path: &std::path::Path, source: mcap::McapError) -> Self {
        match source {
            mcap::McapError::Io(source) => Self::io(path, source),
            source => Self::Mcap { path: path.into(), source },
        }
    }
}

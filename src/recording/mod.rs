//! Recordings as files: read with every checksum verified, mended, cut and merged.
//!
//! A [`Scan`] goes through one file from record to record and trusts nothing that no checksum protects; [`Series`] gives the
//! snapshots of a run out of all of its [segments](segments()). The commands `squirm info`, `verify`, `recover`, `cut` and
//! `merge` are built from the two.

mod copy;
mod cut;
mod info;
mod merge;
mod provenance;
mod range;
mod recover;
mod scan;
mod segments;
mod series;
mod shape;
mod summary;
mod verify;

pub use cut::{Cut, cut, fluid_apart};
pub use info::{FileInfo, Info, TopicInfo, info};
pub use merge::merge;
pub use provenance::{ATTACHMENT, METADATA, Provenance, run_metadata};
pub use range::{Choice, Moment, Range};
pub use recover::{Recovered, recover};
pub use scan::{Channels, Chunk, Part, Scan, Schema};
pub use segments::{FLUID, RUN, fluid_beside, recordings, segment, segments};
pub use series::{Read, Series};
pub use verify::{Finding, Verdict, verify};

use crate::wire::WireError;
use std::path::{Path, PathBuf};

/// Topics of our own messages begin so; the rest is the [kind](crate::wire::Kind)'s word.
pub const TOPICS: &str = "/squirm/";
/// The layout of our own messages; it travels inside every recording as their schema.
pub const FORMAT: &str = include_str!("../../docs/format.md");

/// Why a recording could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is no recording where one was named.
    #[error("there is no recording {}; a run records only what an [[output]] asks it to", .0.display())]
    Absent(PathBuf),
    /// The file is not MCAP.
    #[error("{} is no recording: it does not begin as MCAP files do", .0.display())]
    NoRecording(PathBuf),
    /// Something between whole chunks cannot be trusted.
    #[error("{} is damaged at byte {at}: {what}; `squirm recover` keeps what is whole", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where.
        at: u64,
        /// What is wrong there.
        what: String,
    },
    /// Not one whole snapshot before the file's end.
    #[error("{} ends before its first whole snapshot", .0.display())]
    Empty(PathBuf),
    /// A message that is no snapshot, in a chunk that is whole.
    #[error("{}, chunk at byte {at}: {source}", path.display())]
    Wire {
        /// The file.
        path: PathBuf,
        /// Where its chunk begins.
        at: u64,
        /// What is wrong with it.
        source: WireError,
    },
    /// Files that do not belong together.
    #[error("{} does not continue {}: {why}", second.display(), first.display())]
    Foreign {
        /// The file before.
        first: PathBuf,
        /// The file that does not fit.
        second: PathBuf,
        /// Why.
        why: String,
    },
    /// A file that is there already.
    #[error("{} exists already: name another file with --out, or remove it", .0.display())]
    Exists(PathBuf),
    /// The writer refused.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the writer said.
        source: mcap::McapError,
    },
    /// A range that ends before it begins.
    #[error("the range is reversed: it begins at {from} and ends at {to}")]
    Reversed {
        /// Its beginning.
        from: Moment,
        /// Its end.
        to: Moment,
    },
    /// A request that selects nothing.
    #[error("{0}")]
    Nothing(String),
}

impl RecordingError {
    /// Names the file in a system error.
    fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |source| match source.kind() {
            std::io::ErrorKind::NotFound => Self::Absent(path.into()),
            std::io::ErrorKind::AlreadyExists => Self::Exists(path.into()),
            _ => Self::Io { path: path.into(), source },
        }
    }
}

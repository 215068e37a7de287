//! The bytes that leave a run: one versioned little-endian layout for shared memory and for files (docs/format.md).
//!
//! A snapshot message is a [`Header`], a table of [`Column`]s and the columns' values. The same bytes are published to
//! analyzers on this machine and recorded, so whatever reads one reads the other.

pub mod domain;
mod encode;
mod fields;
mod header;
mod particles;
mod scalars;
mod snapshot;
mod squirmers;
mod status;

pub use encode::Encoder;
pub use fields::Fields;
pub use header::{Column, FLAG_WALLS_Y, Header, MAGIC, VERSION};
pub use particles::Particles;
pub use scalars::{Scalar, Scalars};
pub use snapshot::{Element, Snapshot};
pub use squirmers::{SpeciesRow, Squirmers};
pub use status::Status;

#[cfg(target_endian = "big")]
compile_error!("snapshots are little-endian, and are written and read by copying memory");

/// What one message holds; each kind is a topic of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u32)]
pub enum Kind {
    /// Poses, velocities and forces of the squirmers, with a table of their species.
    Squirmers = 1,
    /// Named numbers about the whole system.
    Scalars = 2,
    /// Density and velocity of the fluid averaged over blocks of cells.
    Fields = 3,
    /// Positions and velocities of a share of the fluid particles.
    Particles = 4,
    /// What a run tells about itself; published by every run, never recorded.
    Status = 5,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 5] = [Self::Squirmers, Self::Scalars, Self::Fields, Self::Particles, Self::Status];

    /// The word for it in pipeline files, topics and service names.
    #[must_use]
    pub const fn topic(self) -> &'static str {
        match self {
            Self::Squirmers => "squirmers",
            Self::Scalars => "scalars",
            Self::Fields => "fields",
            Self::Particles => "particles",
            Self::Status => "status",
        }
    }

    /// The kind with this [`topic`](Self::topic).
    #[must_use]
    pub fn from_topic(topic: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.topic() == topic)
    }

    /// The kind with this number in the header.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|k| *k as u32 == number)
    }
}

/// When and where a snapshot was taken.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stamp {
    /// Identity of the run: random, or a hash of what made it.
    pub run_id: [u8; 16],
    /// Steps done.
    pub step: u64,
    /// Simulated time in tau.
    pub time: f64,
    /// Counts the snapshots of one kind from 0 without gaps, so that a reader sees what it lost.
    pub seq: u64,
    /// Steps between two snapshots of this kind; 0 if they come at no fixed distance.
    pub every: u64,
    /// Edges of the box in a.
    pub box_size: [f64; 3],
    /// Walls at y = 0 and y = L instead of a periodic y direction.
    pub walls: bool,
}

/// Why bytes are not a snapshot, or not the one that was asked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WireError {
    /// Fewer bytes than the header, or than the header announces.
    #[error("the message ends after {have} bytes, {need} are needed")]
    Truncated {
        /// Bytes there are.
        have: usize,
        /// Bytes there should be.
        need: u64,
    },
    /// The first bytes are not [`MAGIC`].
    #[error("not a squirm snapshot: the first eight bytes are {0:02x?}")]
    Magic([u8; 8]),
    /// A layout that this program does not know.
    #[error(
        "snapshot layout version {0}; this program reads version {VERSION}: use the squirm that wrote it, or a newer one"
    )]
    Version(u32),
    /// Header or column table do not match their checksum.
    #[error("damaged snapshot header: checksum {stored:08x} stored, {computed:08x} computed")]
    Checksum {
        /// In the message.
        stored: u32,
        /// Of the message.
        computed: u32,
    },
    /// The header contradicts itself or the message's length.
    #[error("malformed snapshot: {0}")]
    Malformed(String),
    /// A column that is not there.
    #[error("this {kind} snapshot has no column `{name}`")]
    NoColumn {
        /// Topic of the message.
        kind: &'static str,
        /// Name asked for.
        name: String,
    },
    /// A column of another type, or with another number of components.
    #[error("column `{name}` holds {found}, not {wanted}")]
    Type {
        /// Name asked for.
        name: String,
        /// What the message has.
        found: String,
        /// What was asked for.
        wanted: String,
    },
    /// Another kind of message.
    #[error("a {found} snapshot where {wanted} was expected")]
    Kind {
        /// What the message is.
        found: &'static str,
        /// What was asked for.
        wanted: &'static str,
    },
}

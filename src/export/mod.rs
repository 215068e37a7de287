//! Recordings in the formats of other people's tools.
//!
//! Positions are in a, velocities in sqrt(kT/m), times in tau, as everywhere; docs/recordings.md says where each format keeps what.

mod csv;
mod gsd;
mod gsd_file;
mod moments;
mod npz;
mod vtk;
mod xyz;

pub use csv::csv;
pub use gsd::gsd;
pub use moments::{Moment, Moments};
pub use npz::npz;
pub use vtk::vtk;
pub use xyz::xyz;

use crate::recording::{Moment as At, Range, RecordingError};
use crate::wire::{Kind, WireError};
use std::path::{Path, PathBuf};

/// Which snapshots to export.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Selection {
    /// What the format shows by default: tables the last one (of scalars all), others all.
    #[default]
    Usual,
    /// That at this step.
    Step(u64),
    /// That at this time in tau.
    Time(f64),
    /// Those of a range.
    Range(Range),
}

impl Selection {
    /// The snapshots as a range, for formats that hold many.
    #[must_use]
    pub fn range(self) -> Range {
        match self {
            Self::Usual => Range::default(),
            Self::Step(step) => Range { from: Some(At::Step(step)), to: Some(At::Step(step)), every: 1 },
            Self::Time(time) => {
                // Times of snapshots are products of a step and dt, which are rounded.
                let [from, to] = [-1.0, 1.0].map(|side| Some(At::Time(time + side * (1e-9 + 1e-12 * time.abs()))));
                Range { from, to, every: 1 }
            }
            Self::Range(range) => range,
        }
    }
}

/// What was exported.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Exported {
    /// The file, or the one that lists the others.
    pub path: PathBuf,
    /// Snapshots.
    pub snapshots: u64,
    /// Rows of the table, or of the last snapshot.
    pub rows: u64,
    /// How many there were in the run; more than `rows` where only a share was recorded.
    pub population: u64,
    /// Step of the last snapshot.
    pub step: u64,
    /// What the user should know about the recording.
    pub warnings: Vec<String>,
}

impl Exported {
    /// Whether the last snapshot holds all there was; a run can be started exactly from complete tables only.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.rows == self.population
    }
}

/// Why nothing was exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A message that is no snapshot.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// A file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file that is there already.
    #[error("{} exists already", .0.display())]
    Exists(PathBuf),
    /// The recording does not have it.
    #[error("{0}")]
    Absent(String),
    /// The format cannot hold it.
    #[error("{0}")]
    Unfit(String),
}

impl ExportError {
    /// Names the file in a system error.
    fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |source| match source.kind() {
            std::io::ErrorKind::AlreadyExists => Self::Exists(path.into()),
            _ => Self::Io { path: path.into(), source },
        }
    }

    /// No snapshot of these kinds where they were looked for; `last` is the newest that there is.
    fn absent(recording: &Path, kinds: &[Kind], selection: Selection, last: Option<u64>) -> Self {
        let path = recording.display();
        let kinds = kinds.iter().map(|k| k.topic()).collect::<Vec<_>>().join(" or ");
        Self::Absent(match (selection, last) {
            (Selection::Step(at), Some(last)) => {
                format!("{path} has no snapshot of {kinds} at step {at}; the last is at step {last}")
            }
            (Selection::Time(at), Some(last)) => {
                format!("{path} has no snapshot of {kinds} at {at} tau; the last is at step {last}")
            }
            (Selection::Range(_), Some(last)) => {
                format!("{path} has no snapshot of {kinds} in that range; the last is at step {last}")
            }
            _ => format!("{path} has no snapshot of {kinds}: was the topic recorded?"),
        })
    }
}

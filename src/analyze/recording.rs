//! Snapshots out of a recording.

use super::{AnalyzeError, Ending, Source, Visit};
use crate::recording::Series;
use crate::wire::{Kind, Snapshot};
use std::path::{Path, PathBuf};

/// A recording with all of its segments, or a run's folder.
#[derive(Debug, Clone)]
pub struct Recording {
    path: PathBuf,
}

impl Recording {
    /// The recording at `path`.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self { path: path.into() }
    }
}

impl Source for Recording {
    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError> {
        let mut series = Series::open(&self.path, topics)?;
        while let Some(bytes) = series.next_message()? {
            if visit(&Snapshot::parse(&bytes)?)?.is_break() {
                break;
            }
        }
        let read = series.finish();
        Ok(Ending { snapshots: read.snapshots, lost: read.missing, warnings: read.warnings })
    }
}

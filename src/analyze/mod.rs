//! Analyzers and their sources: one code for a run that is going and for one recorded weeks ago.
//!
//! An [`Analyzer`] takes snapshots and ends with a [`Report`]; a [`Source`] is a recording or a live run.

mod live;
pub mod plot;
mod recording;
pub mod statistics;
pub mod swim;

pub use live::{Limits, Live, runs};
pub use recording::Recording;

use crate::recording::RecordingError;
use crate::wire::{Kind, Snapshot, WireError};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Takes snapshots one after another, then says what it found.
pub trait Analyzer {
    /// What it wants to see.
    fn topics(&self) -> Vec<Kind>;

    /// Takes the next snapshot of one of its topics, in the order of time.
    ///
    /// # Errors
    /// If the snapshot cannot be used.
    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError>;

    /// Says what it found in all that it took.
    ///
    /// # Errors
    /// If that was too little.
    fn finish(&mut self) -> Result<Report, AnalyzeError>;
}

/// What a [`Source`] calls with each snapshot.
pub type Visit<'a> = dyn FnMut(&Snapshot<'_>) -> Result<ControlFlow<()>, AnalyzeError> + 'a;

/// Where snapshots come from.
pub trait Source {
    /// Calls `visit` with every snapshot of `topics` until the source ends or `visit` breaks off.
    ///
    /// # Errors
    /// If the source cannot be read, or `visit` failed.
    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError>;
}

/// How a source ended.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Ending {
    /// Snapshots given.
    pub snapshots: u64,
    /// Snapshots that passed unseen.
    pub lost: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// What an analyzer found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Report {
    /// A short table for the terminal.
    pub summary: String,
    /// Names and contents of files.
    pub files: Vec<(String, String)>,
}

impl Report {
    /// Writes the files into `dir`, which is made if it is missing.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, dir: &Path) -> Result<(), AnalyzeError> {
        std::fs::create_dir_all(dir).map_err(AnalyzeError::io(dir))?;
        for (name, content) in &self.files {
            let path = dir.join(name);
            std::fs::write(&path, content).map_err(AnalyzeError::io(&path))?;
        }
        Ok(())
    }
}

/// Why an analysis failed.
#[derive(Debug, thiserror::Error)]
pub enum AnalyzeError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A recording cannot be read, or not to its end.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A message that is not a snapshot.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// No such run is going.
    #[error("no run named `{run}` publishes {topic} here; {}", if live.is_empty() { "no run is live".into() } else { format!("live: {}", live.join(", ")) })]
    NoRun {
        /// The name asked for.
        run: String,
        /// The topic asked for.
        topic: &'static str,
        /// Runs that publish the topic.
        live: Vec<String>,
    },
    /// iceoryx2 refused.
    #[error("cannot {what}: {reason}")]
    Ipc {
        /// What was attempted.
        what: &'static str,
        /// What iceoryx2 said.
        reason: String,
    },
    /// Too little to say anything.
    #[error("{0}")]
    TooLittle(String),
}

impl AnalyzeError {
    /// Names the file in a system error.
    fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |source| Self::Io { path: path.into(), source }
    }
}

/// Lets `analyzer` take all of `source`.
///
/// # Errors
/// If the source or the analyzer fails.
pub fn run(source: &mut dyn Source, analyzer: &mut dyn Analyzer) -> Result<(Report, Ending), AnalyzeError> {
    let topics = analyzer.topics();
    let ending = source.drive(&topics, &mut |s| analyzer.take(s).map(|()| ControlFlow::Continue(())))?;
    Ok((analyzer.finish()?, ending))
}

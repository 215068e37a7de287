//! Analyzers and their sources: one code for a run that is going and for one recorded weeks ago.
//!
//! An [`Analyzer`] takes snapshots and ends with a [`Report`]; a [`Source`] is a recording or a live run. [`KINDS`]
//! lists the analyzers that come with the program.

pub mod clusters;
pub mod flow_field;
mod folder;
mod grid;
pub mod kinds;
mod live;
pub mod pairs;
pub mod picture;
pub mod plot;
pub mod profile;
mod recording;
pub mod space;
pub mod spectrum;
pub mod statistics;
pub mod stretches;
pub mod structure;
pub mod swim;
pub mod table;
mod window;

pub use folder::Folder;
pub use kinds::KINDS;
pub use live::{Limits, Live, Running, running, runs};
pub use recording::Recording;
pub use window::Window;

use crate::recording::RecordingError;
use crate::wire::{Kind, Snapshot, WireError};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// The exit status of an analyzer that is done, but has not seen every snapshot.
pub const DATA_LOST: u8 = 3;

/// Takes snapshots one after another, then says what it found.
pub trait Analyzer {
    /// What it cannot do without.
    fn topics(&self) -> Vec<Kind>;

    /// What it uses, too, where a source has it.
    fn extras(&self) -> Vec<Kind> {
        Vec::new()
    }

    /// Takes the next snapshot. Those of one topic come in the order of time; how two topics follow each other depends
    /// on the source, so whatever needs both pairs them by their step.
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
    /// Whether snapshots of this topic can be asked for. A recording only turns out to have none when it is read.
    fn offers(&self, _topic: Kind) -> bool {
        true
    }

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
    #[error("no run named `{run}` publishes {topic} here; {}", instead(own, live))]
    NoRun {
        /// The name asked for.
        run: String,
        /// The topic asked for.
        topic: &'static str,
        /// What the run of this name does publish, if there is one.
        own: Vec<&'static str>,
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

/// What there is in place of the topic of a run.
fn instead(own: &[&str], live: &[String]) -> String {
    match (own, live) {
        ([], []) => "no run does".into(),
        ([], live) => format!("these do: {}", live.join(", ")),
        (own, _) => format!("it publishes {}", own.join(", ")),
    }
}

impl AnalyzeError {
    /// No snapshot to speak of.
    fn nothing(topic: Kind) -> Self {
        Self::TooLittle(format!(
            "no {0} in these snapshots: was the topic `{0}` recorded, or published?",
            topic.topic()
        ))
    }

    /// Box, numbers or grid are not those of the first snapshot.
    fn changed() -> Self {
        Self::TooLittle("the system changed: these are snapshots of more than one run".into())
    }

    /// Names the file in a system error.
    fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |source| Self::Io { path: path.into(), source }
    }
}

/// Lets `analyzer` take all of `source`; the same moment twice, as where a resumed run overlaps, counts once.
///
/// # Errors
/// If the source or the analyzer fails.
pub fn run(source: &mut dyn Source, analyzer: &mut dyn Analyzer) -> Result<(Report, Ending), AnalyzeError> {
    let mut topics = analyzer.topics();
    topics.extend(analyzer.extras().into_iter().filter(|topic| source.offers(*topic)));
    let mut last: HashMap<Kind, u64> = HashMap::new();
    let ending = source.drive(&topics, &mut |snapshot| {
        let step = snapshot.header.step;
        if last.get(&snapshot.kind()).is_none_or(|last| step > *last) {
            last.insert(snapshot.kind(), step);
            analyzer.take(snapshot)?;
        }
        Ok(ControlFlow::Continue(()))
    })?;
    Ok((analyzer.finish()?, ending))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_asks_for_a_topic_that_is_not_there_learns_what_is() {
        let others = ["a".to_owned(), "b".to_owned()];
        assert_eq!(instead(&["squirmers", "fields"], &others), "it publishes squirmers, fields");
        assert_eq!(instead(&[], &others), "these do: a, b");
        assert_eq!(instead(&[], &[]), "no run does");
    }
}

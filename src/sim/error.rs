//! Why a run did not finish, or did not begin.

use crate::checkpoint::{Unreadable, WriteError};
use crate::gpu::GpuError;
use crate::sink::SinkError;
use crate::state::start::StartError;
use std::path::PathBuf;

/// Why a run did not finish.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A recording, a topic or a table.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// A file or directory.
    #[error("cannot {what} {}: {source}", path.display())]
    File {
        /// What was to be done.
        what: &'static str,
        /// With what.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The output directory holds a run already.
    #[error(
        "{} holds a run already, and no checkpoint from which it could go on: name another directory with --out, or remove it",
        .0.display()
    )]
    Occupied(PathBuf),
    /// The output directory holds a run, but a fresh one was asked for.
    #[error("{} holds a run already, and --fresh never overwrites one: name another directory with --out, or remove it", .0.display())]
    NotFresh(PathBuf),
    /// What was named as the output directory is no directory.
    #[error("{} is a file, not a directory: name another directory with --out", .0.display())]
    NoDirectory(PathBuf),
    /// Another process is writing there.
    #[error("another process is running in {}: wait until it has ended, or name another directory with --out", .0.display())]
    Busy(PathBuf),
    /// The directory's checkpoint belongs to another configuration.
    #[error(
        "the run in {} has another configuration, so it cannot go on:{}\nput the values back, or begin anew with --fresh or another --out",
        dir.display(), differences.iter().map(|line| format!("\n  {line}")).collect::<String>()
    )]
    Differs {
        /// Directory.
        dir: PathBuf,
        /// Each value that differs.
        differences: Vec<String>,
    },
    /// There is nothing left to do.
    #[error(
        "the run in {} is finished: {step} steps are done; raise run.steps to go on from there, or begin anew with --fresh",
        dir.display()
    )]
    Finished {
        /// Directory.
        dir: PathBuf,
        /// Steps done.
        step: u64,
    },
    /// No checkpoint of the directory can be used.
    #[error("{0}; begin anew with --fresh")]
    Checkpoints(#[from] Unreadable),
    /// A checkpoint could not be written. The one before it is as it was.
    #[error(transparent)]
    Checkpoint(#[from] WriteError),
    /// A kernel found that a sum left its range, or a velocity that is not a number.
    #[error("step {step}: {what}; the run was stopped, the recording up to here is complete")]
    Fault {
        /// The step at which it happened, or by which it had.
        step: u64,
        /// What happened where, and what to do.
        what: String,
    },
}

//! `squirm export`: a recorded run as tables.

use super::RUN_FAILED;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `squirm export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A recording, or the folder of a run.
    run: PathBuf,
    /// What to write.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    to: Format,
    /// Folder for the tables [default: beside the recording].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A format that recordings convert to.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum Format {
    /// One table for each topic.
    Csv,
}

/// Converts a recording.
pub fn export(args: &Args) -> ExitCode {
    let Args { run, to: Format::Csv, out } = args;
    let out = out.as_ref().unwrap_or(run);
    eprintln!("error: this build cannot read {} to write tables into {}", run.display(), out.display());
    ExitCode::from(RUN_FAILED)
}

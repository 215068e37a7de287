//! `squirm info`, `verify`, `recover`, `cut`, `merge`: recordings as files.

mod tables;

use super::{DATA_LOST, RUN_FAILED, WRONG_USAGE, print};
use squirm::recording::{self, Cut, Moment, Range, RecordingError};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Which snapshots, for every command that takes a part of a recording.
#[derive(Debug, Clone, clap::Args)]
pub struct Part {
    /// First step, as in 2000, or time, as in 12.5tau.
    #[arg(long, value_name = "STEP|TIMEtau")]
    pub from: Option<Moment>,
    /// Last step or time, included.
    #[arg(long, visible_alias = "until", value_name = "STEP|TIMEtau")]
    pub to: Option<Moment>,
}

impl Part {
    /// The range with every so many snapshots.
    ///
    /// # Errors
    /// If it ends before it begins.
    pub fn range(&self, every: u64) -> Result<Range, RecordingError> {
        Range { from: self.from, to: self.to, every }.forward()
    }
}

/// Arguments of `squirm info`.
#[derive(Debug, clap::Args)]
pub struct InfoArgs {
    /// A recording, with its later segments, or the folder of a run, with all that it recorded.
    file: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Arguments of `squirm verify`.
#[derive(Debug, clap::Args)]
pub struct VerifyArgs {
    /// Recordings, each with its later segments, or folders of runs, with all that they recorded.
    #[arg(required = true)]
    files: Vec<PathBuf>,
}

/// Arguments of `squirm recover`.
#[derive(Debug, clap::Args)]
pub struct RecoverArgs {
    /// The damaged file; of a run in segments each is recovered alone.
    file: PathBuf,
    /// The new file [default: NAME.recovered.mcap beside the damaged one].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Arguments of `squirm cut`.
#[derive(Debug, clap::Args)]
pub struct CutArgs {
    /// A recording, with its later segments, or the folder of a run.
    file: PathBuf,
    #[command(flatten)]
    part: Part,
    /// Only these topics: squirmers, scalars, fields, particles, or a topic for viewers such as /squirmers/scene [default: all].
    #[arg(long, value_name = "TOPIC", value_delimiter = ',')]
    topics: Vec<String>,
    /// Only every Nth snapshot of each kind, the first one included.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// The new file.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Arguments of `squirm merge`.
#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// Segments of one run, in any order; a single file or folder stands for all of its segments.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The new file.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Prints why, and the status: 2 for what the user named wrongly.
pub fn failed(error: &RecordingError) -> ExitCode {
    say!("error: {error}");
    ExitCode::from(match error {
        RecordingError::Absent(_)
        | RecordingError::Exists(_)
        | RecordingError::Foreign { .. }
        | RecordingError::Reversed { .. }
        | RecordingError::Nothing(_) => WRONG_USAGE,
        _ => RUN_FAILED,
    })
}

/// Prints what a recording holds.
pub fn info(args: &InfoArgs) -> ExitCode {
    match recording::info(&args.file) {
        Ok(info) if args.json => match serde_json::to_string_pretty(&info) {
            Ok(text) => print(&(text + "\n")),
            Err(error) => {
                say!("error: {error}");
                ExitCode::from(RUN_FAILED)
            }
        },
        Ok(info) => {
            info.findings.iter().for_each(|finding| say!("warning: {finding}"));
            print(&tables::info(&info))
        }
        Err(error) => failed(&error),
    }
}

/// Checks recordings; the status is that of the worst.
pub fn verify(args: &VerifyArgs) -> ExitCode {
    let mut status = ExitCode::SUCCESS;
    for file in &args.files {
        let verdict = match recording::verify(file) {
            Ok(verdict) => verdict,
            Err(error) => {
                status = failed(&error);
                continue;
            }
        };
        let (chunks, snapshots) = (verdict.chunks, verdict.snapshots);
        let word = if verdict.findings.is_empty() { "clean" } else { "DAMAGED" };
        verdict.findings.iter().for_each(|finding| say!("{finding}"));
        let of = if verdict.files.len() > 1 { format!(" in {} files", verdict.files.len()) } else { String::new() };
        print(&format!("{}: {word}: {chunks} whole chunks, {snapshots} snapshots{of}\n", file.display()));
        if !verdict.findings.is_empty() {
            status = ExitCode::from(RUN_FAILED);
        }
    }
    status
}

/// Saves what is whole of a damaged file.
pub fn recover(args: &RecoverArgs) -> ExitCode {
    let out = args.out.clone().unwrap_or_else(|| args.file.with_extension("recovered.mcap"));
    let done = match recording::recover(&args.file, &out) {
        Ok(done) => done,
        Err(error @ RecordingError::Exists(_)) => return failed(&error),
        Err(error) => {
            say!("error: {error}");
            return ExitCode::from(if matches!(error, RecordingError::Absent(_)) { WRONG_USAGE } else { RUN_FAILED });
        }
    };
    done.findings.iter().for_each(|finding| say!("{finding}"));
    let stated = match done.stated {
        Some(stated) => format!(" of {stated}"),
        None => String::new(),
    };
    let (messages, chunks, attachments) = (done.messages, done.chunks, done.attachments);
    let word = if done.lossy { "something was lost" } else { "nothing was lost" };
    print(&format!(
        "{}: {messages}{stated} messages in {chunks} chunks, {attachments} attachments; {word}\n",
        out.display()
    ));
    if done.lossy { ExitCode::from(DATA_LOST) } else { ExitCode::SUCCESS }
}

/// Copies a part of a recording.
pub fn cut(args: &CutArgs) -> ExitCode {
    let range = args.part.range(args.every);
    written(range.and_then(|range| recording::cut(&args.file, &args.out, range, &args.topics)), &args.out)
}

/// Joins segments.
pub fn merge(args: &MergeArgs) -> ExitCode {
    let (files, apart) = match &args.files[..] {
        [one] => (recording::segments(one), recording::fluid_apart(one)),
        several => (Ok(several.to_vec()), None),
    };
    let mut done = files.and_then(|files| recording::merge(&files, &args.out));
    done.iter_mut().for_each(|done| done.warnings.extend(apart.clone()));
    written(done, &args.out)
}

fn written(done: Result<Cut, RecordingError>, out: &Path) -> ExitCode {
    match done {
        Ok(done) => {
            done.warnings.iter().for_each(|warning| say!("warning: {warning}"));
            print(&format!("{}: {} snapshots, {} messages\n", out.display(), done.snapshots, done.messages))
        }
        Err(error) => failed(&error),
    }
}

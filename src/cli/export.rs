//! `squirm export`: a recorded run as tables.

use super::{RUN_FAILED, WRONG_USAGE, print};
use squirm::analyze::AnalyzeError;
use squirm::analyze::export::{Exported, particles_csv, scalars_csv, squirmers_csv};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `squirm export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A recording, or the folder of a run.
    run: PathBuf,
    /// What to write.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    to: Format,
    /// Folder for the tables [default: `csv` beside the recording].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The snapshot at this step [default: the last one; of the scalars all].
    #[arg(long, value_name = "STEP")]
    at: Option<u64>,
    /// Only this topic; may be given again [default: whatever was recorded].
    #[arg(long, value_enum)]
    topic: Vec<Topic>,
}

/// A format that recordings convert to.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum Format {
    /// One table for each topic.
    Csv,
}

/// What has a table.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Topic {
    /// x,y,z,vx,vy,vz of the fluid, as `from` under `[init]` reads it.
    Particles,
    /// Centre, axis and velocity of every squirmer.
    Squirmers,
    /// Temperature, energies, momenta.
    Scalars,
}

/// Converts one topic of a recording into a table.
type Table = fn(&Path, &Path, Option<u64>) -> Result<Exported, AnalyzeError>;

impl Topic {
    fn table(self) -> (&'static str, Table) {
        match self {
            Self::Particles => ("particles.csv", particles_csv),
            Self::Squirmers => ("squirmers.csv", squirmers_csv),
            Self::Scalars => ("scalars.csv", scalars_csv),
        }
    }
}

/// Converts a recording.
pub fn export(args: &Args) -> ExitCode {
    let Args { run, to: Format::Csv, at, topic, .. } = args;
    let recording = if run.is_dir() { run.join("run.mcap") } else { run.clone() };
    if !recording.is_file() {
        say!("error: there is no recording {}", recording.display());
        say!("help: name the folder of a run, or its run.mcap; a run records only what an [[output]] asks it to");
        return ExitCode::from(WRONG_USAGE);
    }
    let out = args.out.clone().unwrap_or_else(|| recording.with_file_name("csv"));
    let all = [Topic::Particles, Topic::Squirmers, Topic::Scalars];
    let topics = if topic.is_empty() { &all[..] } else { topic };
    if let Some(old) = topics.iter().map(|t| out.join(t.table().0)).find(|path| path.exists()) {
        say!("error: {} exists already", old.display());
        say!("help: remove it, or name another folder with --out");
        return ExitCode::from(WRONG_USAGE);
    }
    match tables(&recording, &out, topics, !topic.is_empty(), *at) {
        Ok(written) => print(&written),
        Err(message) => {
            say!("error: {message}");
            ExitCode::from(RUN_FAILED)
        }
    }
}

/// Writes the tables; a topic that was not recorded is an error only if it was `asked` for, or if it leaves nothing.
fn tables(recording: &Path, out: &Path, topics: &[Topic], asked: bool, at: Option<u64>) -> Result<String, String> {
    let fresh = !out.exists();
    std::fs::create_dir_all(out).map_err(|e| format!("cannot create {}: {e}", out.display()))?;
    let (mut missing, mut text) = (Vec::new(), String::new());
    for topic in topics {
        let (name, table) = topic.table();
        let path = out.join(name);
        let done = match table(recording, &path, at) {
            Err(AnalyzeError::TooLittle(why)) if !asked => {
                missing.push(why);
                continue;
            }
            done => done.map_err(|e| e.to_string())?,
        };
        done.warnings.iter().for_each(|warning| say!("warning: {warning}"));
        let _ = writeln!(text, "{}: {} rows, step {}", path.display(), done.rows, done.step);
        if !done.complete() {
            let (rows, population) = (done.rows, done.population);
            let _ = writeln!(text, "  only {rows} of {population}: with fraction = 1 a run could start from them");
        }
    }
    if missing.len() == topics.len() {
        let why = missing.pop().unwrap_or_default();
        if fresh {
            let _ = std::fs::remove_dir(out);
        }
        return Err(why);
    }
    Ok(text)
}

//! `squirm export`: a recorded run in the formats of other people's tools.

use super::recordings::Part;
use super::{RUN_FAILED, WRONG_USAGE, print};
use squirm::export::{ExportError, Exported, Selection, csv, gsd, npz, vtk, xyz};
use squirm::recording::{Moment, RecordingError, segments};
use squirm::wire::Kind;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `squirm export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A recording, with its later segments and the fluid's beside it, or the folder of a run.
    run: PathBuf,
    /// What to write.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    to: Format,
    /// Folder (csv, vtk) or file (gsd, xyz, npz) [default: csv, vtk, or the recording's name with another ending, beside it].
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// The snapshot at this step or time [default: for csv the last one, of the scalars all; for other formats all].
    #[arg(long, value_name = "STEP|TIMEtau", conflicts_with_all = ["from", "to_moment", "every"])]
    at: Option<Moment>,
    /// First step, as in 2000, or time, as in 12.5tau.
    #[arg(long, value_name = "STEP|TIMEtau")]
    from: Option<Moment>,
    /// Last step or time, included.
    #[arg(long = "until", id = "to_moment", value_name = "STEP|TIMEtau")]
    until: Option<Moment>,
    /// Only every Nth snapshot of each kind, the first one included.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    every: Option<u64>,
    /// Only this topic; may be given again [default: what was recorded and the format holds; of npz not the particles].
    #[arg(long, value_enum)]
    topic: Vec<Topic>,
}

/// A format that recordings convert to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// One table for each topic.
    Csv,
    /// Squirmers and scalars for OVITO, HOOMD-blue and freud.
    Gsd,
    /// Fields and squirmers for ParaView.
    Vtk,
    /// Squirmers and scalars as extended XYZ for OVITO and ASE.
    Xyz,
    /// Arrays for NumPy.
    Npz,
}

/// What was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Topic {
    /// Positions and velocities of the fluid; as csv, `from` under `[init]` reads it.
    Particles,
    /// Centre, axis and velocity of every squirmer.
    Squirmers,
    /// Temperature, energies, momenta.
    Scalars,
    /// Density and velocity of the fluid in blocks of cells.
    Fields,
}

impl Topic {
    fn kind(self) -> Kind {
        match self {
            Self::Particles => Kind::Particles,
            Self::Squirmers => Kind::Squirmers,
            Self::Scalars => Kind::Scalars,
            Self::Fields => Kind::Fields,
        }
    }
}

impl Format {
    /// What it can hold.
    fn holds(self) -> &'static [Topic] {
        match self {
            Self::Csv | Self::Npz => &[Topic::Particles, Topic::Squirmers, Topic::Scalars, Topic::Fields],
            Self::Gsd | Self::Xyz => &[Topic::Squirmers, Topic::Scalars],
            Self::Vtk => &[Topic::Fields, Topic::Squirmers],
        }
    }

    /// What it holds unless something else is asked for: particles need much memory.
    fn usual(self) -> Vec<Topic> {
        self.holds().iter().copied().filter(|t| self != Self::Npz || *t != Topic::Particles).collect()
    }

    /// Where it goes unless something else is asked for.
    fn beside(self, recording: &Path) -> PathBuf {
        match self {
            Self::Csv => recording.with_file_name("csv"),
            Self::Vtk => recording.with_file_name("vtk"),
            Self::Gsd => recording.with_extension("gsd"),
            Self::Xyz => recording.with_extension("xyz"),
            Self::Npz => recording.with_extension("npz"),
        }
    }
}

/// Converts a recording.
pub fn export(args: &Args) -> ExitCode {
    let wrong = |error: &dyn std::fmt::Display, help: &str| {
        say!("error: {error}");
        say!("help: {help}");
        ExitCode::from(WRONG_USAGE)
    };
    let recording = match segments(&args.run) {
        Ok(mut files) => files.swap_remove(0),
        Err(RecordingError::Absent(path)) => {
            let help = "name the folder of a run, or its run.mcap; a run records only what an [[output]] asks it to";
            return wrong(&format!("there is no recording {}", path.display()), help);
        }
        Err(error) => return wrong(&error, "name the folder of a run, or its run.mcap"),
    };
    if let Some(topic) = args.topic.iter().find(|t| !args.to.holds().contains(t)) {
        let (topic, format) = (topic.kind().topic(), format!("{:?}", args.to).to_lowercase());
        return wrong(
            &format!("{format} does not hold {topic}"),
            "choose another format with --to, or leave --topic out",
        );
    }
    let selection = match (args.at, args.from, args.until, args.every) {
        (Some(Moment::Step(step)), ..) => Selection::Step(step),
        (Some(Moment::Time(time)), ..) => Selection::Time(time),
        (None, None, None, None) => Selection::Usual,
        (None, from, to, every) => match (Part { from, to }).range(every.unwrap_or(1)) {
            Ok(range) => Selection::Range(range),
            Err(error) => return wrong(&error, "exchange --from and --until"),
        },
    };
    let topics = if args.topic.is_empty() { args.to.usual() } else { args.topic.clone() };
    let out = args.out.clone().unwrap_or_else(|| args.to.beside(&recording));
    match convert(args, &recording, &out, &topics, selection) {
        Ok(written) => print(&written),
        Err(ExportError::Exists(old)) => {
            wrong(&ExportError::Exists(old), "remove it, or name another place with --out")
        }
        Err(error) => {
            say!("error: {error}");
            ExitCode::from(RUN_FAILED)
        }
    }
}

fn convert(
    args: &Args,
    recording: &Path,
    out: &Path,
    topics: &[Topic],
    selection: Selection,
) -> Result<String, ExportError> {
    let kinds: Vec<Kind> = topics.iter().map(|t| t.kind()).collect();
    let folder = matches!(args.to, Format::Csv | Format::Vtk);
    let fresh = folder && !out.exists();
    if folder {
        std::fs::create_dir_all(out).map_err(|source| ExportError::Io { path: out.into(), source })?;
    }
    let done = match args.to {
        Format::Csv => tables(recording, out, &kinds, !args.topic.is_empty(), selection),
        Format::Gsd => gsd(recording, selection, out).map(|one| vec![one]),
        Format::Xyz => xyz(recording, selection, out).map(|one| vec![one]),
        Format::Npz => npz(recording, selection, &kinds, out).map(|one| vec![one]),
        Format::Vtk => vtk(recording, selection, &kinds, out),
    };
    if done.is_err() && fresh {
        // Only if nothing was written into it.
        let _ = std::fs::remove_dir(out);
    }
    let mut text = String::new();
    for done in done? {
        done.warnings.iter().for_each(|warning| say!("warning: {warning}"));
        let _ = if args.to == Format::Csv {
            writeln!(text, "{}: {} rows, step {}", done.path.display(), done.rows, done.step)
        } else {
            writeln!(text, "{}: {} snapshots, the last at step {}", done.path.display(), done.snapshots, done.step)
        };
        if !done.complete() {
            let (rows, population) = (done.rows, done.population);
            let _ = writeln!(text, "  only {rows} of {population}: with fraction = 1 a run could start from them");
        }
    }
    Ok(text)
}

/// Writes the tables; a topic that was not recorded is an error only if it was `asked` for, or if it leaves nothing.
fn tables(
    recording: &Path,
    out: &Path,
    kinds: &[Kind],
    asked: bool,
    selection: Selection,
) -> Result<Vec<Exported>, ExportError> {
    let path = |kind: &Kind| out.join(format!("{}.csv", kind.topic()));
    if let Some(old) = kinds.iter().map(path).find(|path| path.exists()) {
        return Err(ExportError::Exists(old));
    }
    let (mut missing, mut done) = (None, Vec::new());
    for kind in kinds {
        match csv(recording, *kind, selection, &path(kind)) {
            Err(error @ ExportError::Absent(_)) if !asked => missing = missing.or(Some(error)),
            written => done.push(written?),
        }
    }
    match missing {
        Some(error) if done.is_empty() => Err(error),
        _ => Ok(done),
    }
}

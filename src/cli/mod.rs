//! The command line: what it accepts, and where each subcommand goes.

/// Writes a line to standard error. A reader that has gone, as after `2>&1 | head`, must not end a run.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}

mod adapters;
mod bench;
mod check;
mod export;
mod graph;
mod keys;
mod ps;
mod recordings;
mod render;
mod replay;
mod run;
mod signals;
mod stages;
mod tap;
mod top;
mod watch;

use clap::{CommandFactory, Parser, Subcommand};
use squirm::config::{self, Failure, Loaded};
use squirm::diag::{Diagnostic, Sources};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The exit status of a run that failed.
const RUN_FAILED: u8 = 1;

/// The exit status of a wrong command line or pipeline file; clap uses the same.
const WRONG_USAGE: u8 = 2;

/// The exit status of what is done, but not whole.
const DATA_LOST: u8 = 3;

/// Spheroidal squirmers in a fluid of millions of particles.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Exit status: 0 success, 1 the run failed, 2 the command line or a pipeline file is wrong, \
                  3 done, but data were lost, 130 or 143 the run was stopped by Ctrl-C or a termination signal: what it wrote is complete."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// How stages become kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Form {
    /// Every stage its own kernels.
    Loose,
    /// Neighbouring stages share kernels.
    Fused,
}

impl From<Form> for squirm::gpu::Form {
    fn from(form: Form) -> Self {
        match form {
            Form::Loose => Self::Loose,
            Form::Fused => Self::Fused,
        }
    }
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a pipeline file.
    Run(run::Args),
    /// List the runs of yours that are going on this machine.
    Ps(ps::Args),
    /// Watch a run that is going: progress, speed, temperature, time of each stage.
    Top(top::Args),
    /// Print the snapshots of a run that is going.
    Tap(tap::Args),
    /// Measure how fast cases and pipeline files run on an adapter.
    Bench(bench::Args),
    /// Check pipeline files without a GPU, and print what they mean.
    Check {
        /// Pipeline files.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        #[command(flatten)]
        overrides: Overrides,
    },
    /// Draw the stages of a pipeline file and the buffers between them.
    Graph {
        /// Pipeline file.
        file: PathBuf,
        /// What to draw with.
        #[arg(long, value_enum, default_value_t = graph::Format::Terminal)]
        format: graph::Format,
        /// loose: each stage with the buffers that it reads and writes. fused: what shares a kernel in a run, and the bytes that it moves.
        #[arg(long, value_enum, default_value_t = Form::Loose)]
        plan: Form,
        #[command(flatten)]
        overrides: Overrides,
    },
    /// Document the stages and their parameters.
    Stages {
        /// One kind of stage; all of them if left out. `all` also lists the sections of the file.
        kind: Option<String>,
    },
    /// Print the JSON Schema of pipeline files, for completion in editors.
    Schema,
    /// List the GPUs (and CPU drivers) that a run can use.
    Adapters,
    /// Convert a recorded run to tables (csv), or to what other tools read: gsd, xyz, vtk, npz.
    Export(export::Args),
    /// Say what a recording holds. Reads it from beginning to end.
    Info(recordings::InfoArgs),
    /// Check every checksum and snapshot of a recording, and that none is missing. Exit status 0: clean, 1: not.
    Verify(recordings::VerifyArgs),
    /// Make a complete file from what is whole in a damaged one. Exit status 0: nothing lost, 3: something, 1: nothing readable.
    Recover(recordings::RecoverArgs),
    /// Copy a part of a recording into a new one.
    Cut(recordings::CutArgs),
    /// Join the segments of one run into one file.
    Merge(recordings::MergeArgs),
    /// Publish a recording again: analyzers cannot tell it from the run.
    Replay(replay::Args),
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// Overrides of a pipeline file.
#[derive(Debug, clap::Args)]
struct Overrides {
    /// Override a value, as in --set run.steps=200, --set squirmers.puller.b1=0.1, --set stage.rotate.angle=120.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::Ps(args) => ps::ps(&args),
        Command::Top(args) => top::top(&args),
        Command::Tap(args) => tap::tap(&args),
        Command::Bench(args) => bench::bench(&args),
        Command::Check { files, overrides } => check::check(&files, &overrides.set),
        Command::Graph { file, format, plan, overrides } => graph::graph(&file, format, plan, &overrides.set),
        Command::Stages { kind } => stages::stages(kind.as_deref()),
        Command::Schema => print(&config::schema()),
        Command::Adapters => adapters::adapters(),
        Command::Export(args) => export::export(&args),
        Command::Info(args) => recordings::info(&args),
        Command::Verify(args) => recordings::verify(&args),
        Command::Recover(args) => recordings::recover(&args),
        Command::Cut(args) => recordings::cut(&args),
        Command::Merge(args) => recordings::merge(&args),
        Command::Replay(args) => replay::replay(&args),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "squirm", &mut script);
            print(&String::from_utf8_lossy(&script))
        }
    }
}

/// Lets warnings of the library reach standard error.
fn tell_warnings() {
    let filter = tracing_subscriber::EnvFilter::new("squirm=warn");
    let format = tracing_subscriber::fmt().without_time().with_target(false).with_level(false).with_ansi(false);
    // A reader of standard error that has gone must not end a run; and who has set warnings up before keeps them.
    let _ = format.with_env_filter(filter).with_writer(|| Warnings).log_internal_errors(false).try_init();
}

/// Standard error, each of whose lines is a warning.
struct Warnings;

impl std::io::Write for Warnings {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let mut out = std::io::stderr().lock();
        out.write_all(b"warning: ")?;
        out.write_all(bytes)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        std::io::stderr().flush()
    }
}

/// Writes to standard output; a closed pipe, as after `| head`, is no failure.
fn print(text: &str) -> ExitCode {
    use std::io::{ErrorKind, Write};
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            say!("error: cannot write to standard output: {error}");
            ExitCode::from(RUN_FAILED)
        }
        _ => ExitCode::SUCCESS,
    }
}

/// Reads and checks a pipeline file, and prints its errors; warnings are the caller's to print.
fn load(file: &Path, overrides: &[String]) -> Result<Loaded, ExitCode> {
    let name = file.display().to_string();
    let text = std::fs::read(file).map_err(|error| error.to_string()).and_then(|bytes| {
        String::from_utf8(bytes).map_err(|error| format!("it is no UTF-8 text: {}", error.utf8_error()))
    });
    let text = text.map_err(|error| {
        let diagnostic = Diagnostic::error(format!("the pipeline file {name} cannot be read: {error}"))
            .help("give the path of a pipeline file, such as pipelines/quickstart.toml");
        render::all(&[diagnostic], &Sources::default());
        ExitCode::from(WRONG_USAGE)
    })?;
    let base = file.parent().unwrap_or(Path::new(""));
    config::load(&name, &text, overrides, base).map_err(|Failure { sources, diagnostics }| {
        render::all(&diagnostics, &sources);
        ExitCode::from(WRONG_USAGE)
    })
}

//! `squirm-analyze`: what a run did, from its recording or while it is going.

use clap::{Args, Parser, Subcommand};
use squirm::analyze::swim::Swim;
use squirm::analyze::{AnalyzeError, Analyzer, Limits, Live, Recording, Source, run};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Analyze a recorded or a live run of squirm.
///
/// Exit code 0: done; 1: failed; 2: wrong usage.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Swimming speed along the axis, mean squared displacement and memory of the orientation.
    Swim(From),
}

#[derive(Args)]
struct From {
    /// The recording.
    #[arg(value_name = "FILE.mcap", required_unless_present = "live", conflicts_with = "live")]
    recording: Option<PathBuf>,
    /// A run that is going on this machine.
    #[arg(long, value_name = "RUN")]
    live: Option<String>,
    /// Directory for tables (CSV) and charts (SVG) [default: beside the recording, or RUN.swim].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Watch a live run for this long, not to its end.
    #[arg(long = "for", value_name = "SECONDS", requires = "live", value_parser = seconds)]
    duration: Option<Duration>,
    /// Stop after this many snapshots of a live run.
    #[arg(long, value_name = "N", requires = "live")]
    snapshots: Option<u64>,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    Duration::try_from_secs_f64(value).map_err(|e| e.to_string())
}

fn main() -> ExitCode {
    let Command::Swim(from) = Cli::parse().command;
    match analyze(&from, &mut Swim::default(), "swim") {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}

fn analyze(from: &From, analyzer: &mut dyn Analyzer, name: &str) -> Result<(), AnalyzeError> {
    let (mut source, default): (Box<dyn Source>, PathBuf) = match (&from.recording, &from.live) {
        (Some(path), _) => (Box::new(Recording::new(path)), path.with_extension(name)),
        (None, live) => {
            let run = live.as_deref().unwrap_or_default();
            let limits = Limits { duration: from.duration, snapshots: from.snapshots, stop: interrupted() };
            (Box::new(Live::new(run, limits)), Path::new(run).with_extension(name))
        }
    };
    let (report, ending) = run(source.as_mut(), analyzer)?;
    let out = from.out.clone().unwrap_or(default);
    report.write(&out)?;
    for warning in &ending.warnings {
        eprintln!("warning: {warning}");
    }
    print!("{}", report.summary);
    println!("{} snapshots; {} files in {}", ending.snapshots, report.files.len(), out.display());
    Ok(())
}

/// Becomes true at the first Ctrl-C, so that what was seen of a live run is still written; the second one kills.
fn interrupted() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        // Registered in this order: the flag is looked at before it is set. Without handlers Ctrl-C just ends the program.
        let _ = signal_hook::flag::register_conditional_default(signal, Arc::clone(&flag));
        let _ = signal_hook::flag::register(signal, Arc::clone(&flag));
    }
    flag
}

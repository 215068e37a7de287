//! `squirm run`: loads a pipeline file and starts the simulation.

use super::{Overrides, RUN_FAILED, load, render};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `squirm run`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Pipeline file.
    file: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    /// Folder for everything that the run writes [default: runs/NAME].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// GPU to use: part of its name, or its number in `squirm adapters`.
    #[arg(long, value_name = "NAME|INDEX")]
    adapter: Option<String>,
    /// Print only errors.
    #[arg(long)]
    quiet: bool,
}

/// Runs the file.
pub fn run(args: &Args) -> ExitCode {
    let loaded = match load(&args.file, &args.overrides.set) {
        Ok(loaded) => loaded,
        Err(code) => return code,
    };
    if !args.quiet {
        render::all(&loaded.warnings, &loaded.sources);
    }
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("runs").join(&loaded.plan.name));
    let adapter = args.adapter.as_deref().unwrap_or("the first adapter");
    eprintln!("error: this build has no step loop, so it cannot run on {adapter} and write to {}", out.display());
    ExitCode::from(RUN_FAILED)
}

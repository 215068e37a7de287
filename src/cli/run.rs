//! `squirm run`: loads a pipeline file and starts the simulation.

use super::{Overrides, RUN_FAILED, WRONG_USAGE, load, print, render};
use squirm::config::Loaded;
use squirm::gpu::GpuError;
use squirm::sim::{Options, RunError, Watch};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Arguments of `squirm run`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Pipeline file.
    file: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    /// Folder for everything that the run writes [default: runs/NAME, or runs/NAME-2 and so on].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// GPU to use: part of its name, or its number in `squirm adapters`.
    #[arg(long, value_name = "NAME|INDEX", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    adapter: Option<String>,
    /// How stages become kernels: fused, where neighbours share one, or loose, where each has its own. The state is the same in every bit.
    #[arg(long, value_enum, default_value_t = super::Form::Fused)]
    plan: super::Form,
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
        super::tell_warnings();
    }
    let out = args.out.clone().unwrap_or_else(|| free_directory(&loaded.plan.name));
    let options = Options {
        out,
        adapter: args.adapter.clone(),
        command: std::env::args().collect::<Vec<_>>().join(" "),
        form: args.plan.into(),
    };
    let signal = super::signals::first();
    let mut watch = Progress::default();
    (watch.quiet, watch.signal) = (args.quiet, signal.clone());
    match squirm::sim::run(&loaded.plan, &options, &mut watch) {
        Ok(summary) => {
            drop(watch);
            let written = format!("{summary}\n  in {}\n", options.out.display());
            let status = if args.quiet { ExitCode::SUCCESS } else { print(&written) };
            if summary.stopped { super::signals::status(&signal) } else { status }
        }
        Err(error) => {
            drop(watch);
            report(&loaded, &error)
        }
    }
}

/// Prints why a run failed; what the file asks for and the adapter cannot give is shown at its place in the file.
pub fn report(loaded: &Loaded, error: &RunError) -> ExitCode {
    let found = match error {
        RunError::Gpu(GpuError::TooLarge { limit, adapter, .. }) => loaded.exceeds(adapter, *limit),
        RunError::Gpu(GpuError::OutOfMemory { .. }) => vec![loaded.too_large(error.to_string())],
        RunError::Start(error) => vec![loaded.cannot_start(error)],
        _ => Vec::new(),
    };
    if found.is_empty() {
        say!("error: {error}");
        return ExitCode::from(match error {
            RunError::Occupied(_) | RunError::NoDirectory(_) | RunError::Gpu(GpuError::NoSuchAdapter { .. }) => {
                WRONG_USAGE
            }
            _ => RUN_FAILED,
        });
    }
    render::all(&found, &loaded.sources);
    ExitCode::from(WRONG_USAGE)
}

/// `runs/NAME`, or `runs/NAME-2` and so on where there is a run already.
fn free_directory(name: &str) -> PathBuf {
    let numbered = |n: u32| PathBuf::from("runs").join(if n == 1 { name.to_owned() } else { format!("{name}-{n}") });
    (1..).map(numbered).find(|dir| !dir.exists()).unwrap_or_else(|| numbered(1))
}

/// A bar on a terminal, a line every ten seconds elsewhere.
#[derive(Default)]
struct Progress {
    quiet: bool,
    signal: Arc<AtomicUsize>,
    bar: Option<indicatif::ProgressBar>,
    steps: u64,
    began: Option<Instant>,
    last: Option<Instant>,
}

impl Watch for Progress {
    fn begin(&mut self, adapter: &str, steps: u64) {
        if self.quiet {
            return;
        }
        say!("{steps} steps on {adapter}");
        self.steps = steps;
        self.began = Some(Instant::now());
        if std::io::stderr().is_terminal() {
            let style = indicatif::ProgressStyle::with_template("{bar:40} {pos}/{len} steps, {per_sec}, {eta} left")
                .unwrap_or_else(|_| indicatif::ProgressStyle::default_bar());
            self.bar = Some(indicatif::ProgressBar::new(steps).with_style(style));
        }
    }

    fn live(&mut self, name: &str) {
        if !self.quiet {
            say!("watch it with: squirm top {name}");
        }
    }

    fn progress(&mut self, done: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            return;
        }
        let Some(began) = self.began else { return };
        let elapsed = began.elapsed().as_secs_f64();
        let due = self.last.is_none_or(|last| last.elapsed() >= Duration::from_secs(10));
        if done > 0 && (due || done == self.steps) {
            self.last = Some(Instant::now());
            #[allow(clippy::cast_precision_loss)]
            let (done_f, rest) = (done as f64, (self.steps - done) as f64);
            let rate = done_f / elapsed.max(1e-9);
            say!("{done}/{} steps, {rate:.1} steps/s, {:.0} s left", self.steps, rest / rate);
        }
    }

    fn stop(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

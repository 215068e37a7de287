//! `squirm run`: loads a pipeline file and starts the simulation.

use super::{DATA_LOST, Overrides, RUN_FAILED, WRONG_USAGE, load, print, render};
use squirm::config::{Loaded, bytes, meaning};
use squirm::diag::Diagnostic;
use squirm::gpu::GpuError;
use squirm::sim::{Options, RunError, Watch};
use squirm::wire::domain;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
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
    /// Folder for everything that the run writes. If it holds a checkpoint of the same configuration, the run goes on from there
    /// [default: the folder of the last run of this configuration, or a new one: runs/NAME, or runs/NAME-2 and so on].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Begin anew, in a folder that holds no run.
    #[arg(long)]
    fresh: bool,
    /// Write a checkpoint and end within this time, status 0: seconds, or as in 90m, 23h30m, 23:30:00, 1-12:00:00.
    #[arg(long, value_name = "TIME", value_parser = walltime)]
    walltime: Option<Duration>,
    /// For tests: break something on purpose, as in nan@120, infinity@120, lost@120 after 120 steps.
    #[arg(long, value_name = "WHAT@STEP", hide = true)]
    inject: Option<squirm::sim::Injection>,
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
    let deadline = args.walltime.map(|time| Instant::now() + time);
    let loaded = match load(&args.file, &args.overrides.set) {
        Ok(loaded) => loaded,
        Err(code) => return code,
    };
    if !args.quiet {
        render::all(&loaded.warnings, &loaded.sources);
        super::tell_warnings();
    }
    let out = args.out.clone().unwrap_or_else(|| squirm::sim::choose(&loaded.plan, args.plan.into(), args.fresh));
    if !args.quiet {
        render::all(short_of_disk(&loaded, &out).as_slice(), &loaded.sources);
    }
    let options = Options {
        out,
        adapter: args.adapter.clone(),
        command: std::env::args().collect::<Vec<_>>().join(" "),
        form: args.plan.into(),
        fresh: args.fresh,
        deadline,
        inject: args.inject,
    };
    let signal = super::signals::first();
    let mut watch = Progress::default();
    (watch.quiet, watch.signal) = (args.quiet, signal.clone());
    match squirm::sim::run(&loaded.plan, &options, &mut watch) {
        Ok(summary) => {
            drop(watch);
            let written = format!("{summary}\n  in {}\n", options.out.display());
            let status = if args.quiet { ExitCode::SUCCESS } else { print(&written) };
            let signalled = signal.load(Ordering::Relaxed) != 0;
            if summary.stopped && signalled {
                return super::signals::status(&signal);
            }
            if summary.lost.is_empty() {
                return status;
            }
            say!("data were lost: {}", summary.lost.join("; "));
            ExitCode::from(DATA_LOST)
        }
        Err(finished @ RunError::Finished { .. }) => {
            drop(watch);
            if !args.quiet {
                say!("{finished}");
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            drop(watch);
            report(&loaded, &error)
        }
    }
}

/// What to say if the disk may not have the room that the run needs in this folder.
fn short_of_disk(loaded: &Loaded, out: &Path) -> Option<Diagnostic> {
    let meaning = meaning(loaded);
    let absolute = std::path::absolute(out).ok()?;
    let free = domain::free_in(absolute.ancestors().find(|folder| folder.is_dir())?)?;
    // What an earlier part of the run has written need not be written again.
    let there: u64 =
        std::fs::read_dir(out).into_iter().flatten().flatten().filter_map(|e| Some(e.metadata().ok()?.len())).sum();
    let needed = meaning.disk().saturating_sub(there);
    (needed > free).then(|| {
        let (outputs, checkpoints) = (meaning.disk() - meaning.checkpoints(), meaning.checkpoints());
        Diagnostic::warning(format!(
            "this run may need {} on the disk of {} ({} for outputs before compression, {} for checkpoints), which has {} free",
            bytes(needed),
            out.display(),
            bytes(outputs),
            bytes(checkpoints),
            bytes(free)
        ))
        .help("make room, name another disk with --out, or let outputs come less often; a full disk ends the run, which can then go on from its checkpoint")
    })
}

/// Prints why a run failed; what the file asks for and the adapter cannot give is shown at its place in the file.
pub fn report(loaded: &Loaded, error: &RunError) -> ExitCode {
    let found = match error {
        RunError::Gpu(GpuError::TooLarge { .. } | GpuError::OutOfMemory { .. }) => {
            vec![loaded.too_large(error.to_string())]
        }
        RunError::Start(error) => vec![loaded.cannot_start(error)],
        _ => Vec::new(),
    };
    if found.is_empty() {
        say!("error: {error}");
        return ExitCode::from(match error {
            RunError::Occupied(_)
            | RunError::NotFresh(_)
            | RunError::NoDirectory(_)
            | RunError::Differs { .. }
            | RunError::Gpu(GpuError::NoSuchAdapter { .. }) => WRONG_USAGE,
            _ => RUN_FAILED,
        });
    }
    render::all(&found, &loaded.sources);
    // Memory that other programs have may be free tomorrow: the file is not wrong.
    let short = matches!(error, RunError::Gpu(GpuError::OutOfMemory { .. }));
    ExitCode::from(if short { RUN_FAILED } else { WRONG_USAGE })
}

/// A time as people and batch systems write it: seconds, units as in `1d2h30m5s`, or `[DAYS-]HOURS:MINUTES:SECONDS`.
fn walltime(text: &str) -> Result<Duration, String> {
    let (days, clock) = match text.split_once('-') {
        Some((days, clock)) => (days.parse::<u64>().map_err(|_| format!("`{days}` is no number of days"))?, clock),
        None => (0, text),
    };
    let number = |text: &str| text.parse::<u64>().map_err(|_| format!("`{text}` is no whole number"));
    let mut seconds: u64 = 0;
    if clock.contains(':') {
        for part in clock.split(':') {
            seconds = seconds.saturating_mul(60).saturating_add(number(part)?);
        }
    } else {
        let mut rest = clock;
        while let Some(end) = rest.find(|c: char| c.is_ascii_alphabetic()) {
            let unit = match &rest[end..=end] {
                "d" => 86_400,
                "h" => 3600,
                "m" => 60,
                "s" => 1,
                other => return Err(format!("`{other}` is no unit: write d, h, m or s")),
            };
            seconds = seconds.saturating_add(number(&rest[..end])?.saturating_mul(unit));
            rest = &rest[end + 1..];
        }
        if !rest.is_empty() || clock.is_empty() {
            seconds = seconds.saturating_add(number(rest)?);
        }
    }
    // Longer than any machine lives, and short enough for every clock.
    Ok(Duration::from_secs(seconds.saturating_add(days.saturating_mul(86_400)).min(1 << 32)))
}

/// A bar on a terminal, a line every ten seconds elsewhere.
#[derive(Default)]
struct Progress {
    quiet: bool,
    signal: Arc<AtomicUsize>,
    bar: Option<indicatif::ProgressBar>,
    steps: u64,
    /// Steps that earlier parts of the run have done.
    before: u64,
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

    fn resume(&mut self, step: u64, remarks: &[String]) {
        remarks.iter().for_each(|remark| say!("warning: {remark}"));
        if !self.quiet {
            say!("going on after {step} steps");
        }
        self.before = step;
        if let Some(bar) = &self.bar {
            bar.set_position(step);
            bar.reset_eta();
        }
    }

    fn progress(&mut self, done: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            return;
        }
        let Some(began) = self.began else { return };
        let elapsed = began.elapsed().as_secs_f64();
        let due = done > self.before && self.last.is_none_or(|last| last.elapsed() >= Duration::from_secs(10));
        if due || done == self.steps && done > self.before {
            self.last = Some(Instant::now());
            #[allow(clippy::cast_precision_loss)]
            let (new, rest) = ((done - self.before) as f64, (self.steps - done) as f64);
            let rate = new / elapsed.max(1e-9);
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

#[cfg(test)]
mod tests {
    use super::walltime;

    #[test]
    fn times_are_read_as_people_write_them() {
        let cases = [
            ("90", 90),
            ("90m", 5400),
            ("23h30m", 84_600),
            ("1d2h3m4s", 93_784),
            ("10:00", 600),
            ("23:30:00", 84_600),
            ("1-12:00:00", 129_600),
        ];
        for (text, seconds) in cases {
            assert_eq!(walltime(text).map(|d| d.as_secs()), Ok(seconds), "{text}");
        }
        for text in ["", "m", "1x", "1:x", "-5", "1.5h", "h5", "99999999999999999999"] {
            assert!(walltime(text).is_err(), "{text}");
        }
    }
}

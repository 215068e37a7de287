//! `squirm replay`: a recording published again, steered by keys on a terminal and by lines elsewhere.

use super::keys::Keys;
use super::recordings::{Part, failed};
use super::{DATA_LOST, RUN_FAILED, WRONG_USAGE, print};
use squirm::replay::{self, Command, Control, Options, Pace, ReplayError};
use squirm::sink::SinkError;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Arguments of `squirm replay`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A recording, with its later segments and the fluid's beside it, or the folder of a run.
    file: PathBuf,
    /// Simulated time in tau per second.
    #[arg(long, value_name = "TAU", default_value_t = 1.0, value_parser = positive, conflicts_with = "max")]
    speed: f64,
    /// As fast as its readers take it, without a loss.
    #[arg(long)]
    max: bool,
    /// With --max, wait no longer than this for a reader that takes nothing.
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0, value_parser = positive)]
    patience: f64,
    #[command(flatten)]
    part: Part,
    /// Publish under this name [default: that of the run].
    #[arg(long, value_name = "RUN", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    name: Option<String>,
    /// Begin again at the end, until stopped.
    #[arg(long = "loop")]
    repeat: bool,
    /// Begin when so many programs have subscribed.
    #[arg(long, value_name = "N", default_value_t = 0)]
    wait_for: usize,
    /// Print only errors.
    #[arg(long)]
    quiet: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && f64::is_finite(value) => Ok(value),
        _ => Err("a number above 0 is needed".into()),
    }
}

/// Replays a recording.
pub fn replay(args: &Args) -> ExitCode {
    let pace =
        if args.max { Pace::Max(Duration::from_secs_f64(args.patience.min(1e9))) } else { Pace::Speed(args.speed) };
    let range = match args.part.range(1) {
        Ok(range) => range,
        Err(error) => return failed(&error),
    };
    let (name, repeat, wait_for) = (args.name.clone(), args.repeat, args.wait_for);
    let signal = super::signals::first();
    let mut desk = Desk { keys: Keys::new(), signal: signal.clone(), quiet: args.quiet, waits: wait_for, line: false };
    let done = replay::replay(&args.file, &Options { name, pace, range, repeat, wait_for }, &mut desk);
    desk.end_line();
    drop(desk);
    match done {
        Ok(done) => {
            done.warnings.iter().for_each(|warning| say!("warning: {warning}"));
            let lost = match done.dropped {
                0 => String::new(),
                n => format!("; {n} did not reach a reader that was too slow"),
            };
            let status = print(&format!("{} snapshots published{lost}\n", done.snapshots));
            match signal.load(Ordering::Relaxed) {
                0 if args.max && done.dropped > 0 => ExitCode::from(DATA_LOST),
                0 => status,
                _ => super::signals::status(&signal),
            }
        }
        Err(ReplayError::Recording(error)) => failed(&error),
        Err(error) => {
            say!("error: {error}");
            let taken = matches!(error, ReplayError::Sink(SinkError::Taken(_)));
            if taken {
                say!("help: name the replay with --name");
            }
            ExitCode::from(if taken { WRONG_USAGE } else { RUN_FAILED })
        }
    }
}

/// Where the user sits.
struct Desk {
    keys: Keys,
    signal: Arc<AtomicUsize>,
    quiet: bool,
    waits: usize,
    line: bool,
}

impl Desk {
    /// Leaves the line that is written again and again.
    fn end_line(&mut self) {
        if std::mem::take(&mut self.line) {
            say!();
        }
    }
}

impl Control for Desk {
    fn begin(&mut self, name: &str) {
        if !self.quiet {
            let wait = if self.waits > 0 { format!("; waiting for {} readers", self.waits) } else { String::new() };
            say!("publishing as {name}{wait}; {}", self.keys.help());
        }
    }

    fn command(&mut self) -> Option<Command> {
        if self.signal.load(Ordering::Relaxed) != 0 {
            return Some(Command::Quit);
        }
        self.keys.next()
    }

    fn progress(&mut self, step: u64, time: f64, paused: bool) {
        if self.quiet || !std::io::stderr().is_terminal() {
            return;
        }
        let held = if paused { ", held" } else { "" };
        // The rest of an earlier, longer line is wiped out.
        let _ = write!(std::io::stderr(), "\rstep {step}, {time:.2} tau{held}\x1b[K");
        self.line = true;
    }
}

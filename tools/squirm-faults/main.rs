//! `squirm-faults`: breaks runs in every way that breaks them in the field, and counts what is lost.

mod checkpoints;
mod child;
mod disk;
mod kill;
mod record;
mod recordings;
mod signals;
mod table;

use clap::{Args, Parser, Subcommand};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::PathBuf;
use std::process::ExitCode;
use table::Row;

/// Kill runs, send them signals, damage their checkpoints and recordings, fill their disk; print what became of each, with figures.
///
/// Exit code 0: nothing was lost; 1: something was; 2: a case could not be run.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    case: Case,
    #[command(flatten)]
    common: Common,
}

#[derive(Subcommand)]
enum Case {
    /// kill -9 at random instants, then resume to the end: the state, the recording and the tables must be those of an undisturbed run.
    Kill {
        /// Instants.
        #[arg(long, default_value_t = 200)]
        count: u32,
    },
    /// Cut and flipped checkpoints: each must be refused, and the one before used.
    Checkpoints {
        /// Damaged files.
        #[arg(long, default_value_t = 1000)]
        count: u32,
    },
    /// SIGINT, SIGTERM and SIGUSR1 in turn at random instants: status, time, complete files, and a second one.
    Signals {
        /// Instants.
        #[arg(long, default_value_t = 50)]
        count: u32,
    },
    /// Recordings cut at every 4 kB and at each byte of the last 1 kB, and with a turned bit: nothing wrong may be read, and all that is
    /// whole must be recovered.
    Recordings {
        /// Copies of each recording with a turned bit; cuts at its end are no more than these.
        #[arg(long, default_value_t = 1000)]
        count: u32,
    },
    /// A disk that is full: needs the right to mount one of a few megabytes.
    Disk {
        /// Sizes.
        #[arg(long, default_value_t = 8)]
        count: u32,
    },
}

#[derive(Args)]
struct Common {
    /// The program [default: `squirm` beside this one].
    #[arg(long, global = true, value_name = "FILE")]
    squirm: Option<PathBuf>,
    /// Seed of the instants and damages.
    #[arg(long, global = true, default_value_t = 1)]
    seed: u64,
}

fn main() -> ExitCode {
    let Cli { case, common } = Cli::parse();
    match run(&case, &common) {
        Ok(rows) => {
            print!("{}", table::text(&rows));
            if rows.iter().all(Row::passed) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

fn run(case: &Case, common: &Common) -> Result<Vec<Row>, String> {
    let beside = || std::env::current_exe().map(|me| me.with_file_name("squirm")).map_err(|e| e.to_string());
    let squirm = common.squirm.clone().map_or_else(beside, Ok)?;
    let absent = |_| format!("there is no {}: build it, or name it with --squirm", squirm.display());
    // Runs start in folders of their own.
    let squirm = squirm.canonicalize().map_err(absent)?;
    let mut random = ChaCha8Rng::seed_from_u64(common.seed);
    match case {
        Case::Kill { count } => kill::kill(&squirm, *count, &mut random),
        Case::Checkpoints { count } => checkpoints::checkpoints(&squirm, *count, &mut random),
        Case::Signals { count } => signals::signals(&squirm, *count, &mut random),
        Case::Recordings { count } => recordings::recordings(&squirm, *count, &mut random),
        Case::Disk { count } => disk::disk(&squirm, *count),
    }
}

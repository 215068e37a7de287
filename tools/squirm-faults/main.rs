//! `squirm-faults`: breaks runs in every way that breaks them in the field, and counts what is lost.

mod all;
mod checkpoints;
mod child;
mod disk;
mod kill;
mod memory;
mod mutations;
mod pipelines;
mod readers;
mod record;
mod recordings;
mod signals;
mod soak;
mod stopped;
mod table;
mod watcher;

use clap::{Args, Parser, Subcommand};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::PathBuf;
use std::process::ExitCode;
use table::Row;

/// Kill runs and their readers, stop them, send them signals, damage their files, fill their disk and their shared memory; print
/// what became of each, with figures.
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
    /// Every case, one table: a few trials of each.
    All {
        /// As many trials as the single cases make, and a soak of an hour: about two and a half hours.
        #[arg(long)]
        long: bool,
    },
    /// kill -9 at random instants, then resume to the end: the state, the recording and the tables must be those of an undisturbed run.
    Kill {
        /// Runs, each killed at one to four instants.
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
    /// kill -9 of readers of a run that goes, at random instants of their lives: the run must not feel it.
    Readers {
        /// Kills; as many readers leave by themselves, to compare.
        #[arg(long, default_value_t = 100)]
        count: u32,
    },
    /// A reader that is stopped by SIGSTOP and goes on later.
    Stopped {
        /// How long a run goes beside it.
        #[arg(long, default_value_t = 60)]
        seconds: u32,
    },
    /// A disk that is full: needs the right to mount one of a few megabytes.
    Disk {
        /// Sizes.
        #[arg(long, default_value_t = 8)]
        count: u32,
    },
    /// Shared memory that is too small, or full: needs the right to mount another.
    Memory,
    /// Changed copies of pipeline files: neither panic nor hang, and every error has a place.
    Pipelines {
        /// Copies.
        #[arg(long, default_value_t = 200_000)]
        count: u32,
        /// Folder with the files to change, those in its folders included.
        #[arg(long, value_name = "DIR", default_value_os_t = all::shipped())]
        files: PathBuf,
        /// Print the copy of this number, and do nothing else.
        #[arg(long, value_name = "NUMBER")]
        show: Option<u32>,
        /// For the case itself: check the copies from this number on in this process.
        #[arg(long, value_name = "NUMBER", hide = true)]
        from: Option<u32>,
    },
    /// A run that goes for long with readers, recordings and checkpoints: memory, descriptors and threads must not grow.
    Soak {
        /// How long.
        #[arg(long, default_value_t = 60.0)]
        minutes: f64,
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
        Case::All { long } => all::all(&squirm, common.seed, *long),
        Case::Kill { count } => kill::kill(&squirm, *count, &mut random),
        Case::Checkpoints { count } => checkpoints::checkpoints(&squirm, *count, &mut random),
        Case::Signals { count } => signals::signals(&squirm, *count, &mut random),
        Case::Recordings { count } => recordings::recordings(&squirm, *count, &mut random),
        Case::Readers { count } => readers::readers(&squirm, *count, &mut random),
        Case::Stopped { seconds } => stopped::stopped(&squirm, *seconds),
        Case::Disk { count } => disk::disk(&squirm, *count),
        Case::Memory => memory::memory(&squirm),
        Case::Pipelines { count, files, show: None, from: None } => {
            pipelines::pipelines(&squirm, files, *count, common.seed)
        }
        Case::Pipelines { files, show: Some(number), .. } => pipelines::show(files, common.seed, *number),
        Case::Pipelines { files, count, from: Some(from), .. } => pipelines::work(files, common.seed, *from..*count),
        Case::Soak { minutes } => soak::soak(&squirm, *minutes, &mut random),
    }
}

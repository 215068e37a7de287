//! The step loop: steps are submitted ahead, snapshots leave on a thread of their own, and nothing in the loop waits for the host.

mod analyzers;
mod books;
mod directory;
mod error;
mod faults;
mod frames;
mod inject;
mod keeper;
mod live;
mod outputs;
mod saved;
mod summary;
mod turns;

pub use books::Books;
pub use directory::choose;
pub use error::RunError;
pub use inject::Injection;
pub use summary::{Speed, Summary, SwimSpeed};

use crate::gpu::{Form, Gpu, Session};
use crate::graph::Plan;
use analyzers::Analyzers;
use keeper::Keeper;
use live::Live;
use outputs::Outputs;
use saved::Note;
use std::path::PathBuf;
use std::time::Instant;
use turns::Turns;

/// How a plan is to be run.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Directory for everything the run writes. Where it holds a checkpoint of this plan the run goes on from there.
    pub out: PathBuf,
    /// Number, or part of the name, of the adapter.
    pub adapter: Option<String>,
    /// The command line, for the record.
    pub command: String,
    /// How stages become kernels.
    pub form: Form,
    /// Begin anew: the directory must not hold a run.
    pub fresh: bool,
    /// When the process has to have ended: the run writes a checkpoint and ends before.
    pub deadline: Option<Instant>,
    /// A fault made on purpose, for tests.
    pub inject: Option<Injection>,
}

/// Told how the run goes on; what a progress bar needs.
pub trait Watch {
    /// The run begins on this adapter.
    fn begin(&mut self, adapter: &str, steps: u64);
    /// The name under which analyzers and `squirm top` find the run; not called for a run that cannot be watched.
    fn live(&mut self, _name: &str) {}
    /// The run goes on from a checkpoint after `step` steps; what else is to be known of it.
    fn resume(&mut self, _step: u64, _remarks: &[String]) {}
    /// So many steps are done.
    fn progress(&mut self, done: u64);
    /// Whether the run is to end before its last step, with everything that it has written complete.
    fn stop(&self) -> bool {
        false
    }
}

/// Runs a plan from its start, or from the checkpoint in the directory, to its last step, or until [`Watch::stop`] or the deadline.
///
/// # Errors
/// If it cannot start or go on, or had to stop; what was recorded until then stays readable, and the last checkpoint intact.
pub fn run(plan: &Plan, options: &Options, watch: &mut dyn Watch) -> Result<Summary, RunError> {
    let dir = &options.out;
    let claimed = if dir.is_dir() { Some(directory::claim(dir)?) } else { None };
    let saved = directory::inspect(dir, plan, options.form, options.fresh)?;
    let gpu = Gpu::open(options.adapter.as_deref())?;
    let session = match &saved {
        Some(saved) => {
            let at = (saved.note.particles, saved.note.step);
            Session::resumed(&gpu, plan, at, options.form, &saved.buffers())?
        }
        None => {
            Session::fits(&gpu, plan, options.form)?;
            Session::formed(&gpu, plan, &crate::state::start::start(&plan.system)?, options.form)?
        }
    };
    let run_id = saved.as_ref().map_or_else(|| outputs::identity(plan), |s| s.note.run_id);
    let live = Live::open(plan, options, &session, run_id)?;
    let done = Start { plan, options, saved, claimed, run_id }.run(session, &live, watch);
    live.end(done.as_ref().err());
    done
}

/// A run whose session is made, and which those who watch runs can see.
struct Start<'a> {
    plan: &'a Plan,
    options: &'a Options,
    saved: Option<saved::Saved>,
    claimed: Option<directory::Claim>,
    run_id: [u8; 16],
}

impl Start<'_> {
    fn run(self, session: Session, live: &Live, watch: &mut dyn Watch) -> Result<Summary, RunError> {
        let Self { plan, options, saved, claimed, run_id } = self;
        let dir = &options.out;
        let mut outputs = Outputs::new(plan, &session, (run_id, live), saved.as_ref())?;
        std::fs::create_dir_all(dir).map_err(outputs::file("create", dir))?;
        let _claim = match claimed {
            Some(claim) => claim,
            None => directory::claim(dir)?,
        };
        let note = Note { adapter: adapter(&session), ..Note::of(plan, options.form, run_id) };
        let mut keeper = Keeper::new(dir, &plan.checkpoints);
        watch.begin(&session.adapter(), plan.system.run.steps);
        live.name().into_iter().for_each(|name| watch.live(name));
        if let Some(saved) = &saved {
            watch.resume(saved.note.step, &remarks(saved, &note));
            saved.put_aside()?;
        } else {
            directory::check_free(dir)?;
            turns::keep_start(&mut keeper, &session, plan, &note)?;
        }
        outputs.open(plan, options, &session, saved.as_ref())?;
        let analyzers = Analyzers::start(&plan.analyzers, dir, live.name());
        let mut turns = Turns::new(plan, (session, outputs, live), (keeper, note), saved.as_ref(), options)?;
        let done = turns.run(watch).and_then(|()| turns.close(options, watch));
        let complete = done.as_ref().is_ok_and(|summary| !summary.stopped);
        let lost = analyzers.end(if complete { analyzers::PATIENCE } else { analyzers::HASTE });
        done.and_then(|mut summary| summary.lose(lost, dir).map(|()| summary))
    }
}

fn adapter(session: &Session) -> String {
    format!("{}, {}", session.adapter(), session.driver())
}

/// What the user should know of a resumption.
fn remarks(saved: &saved::Saved, now: &Note) -> Vec<String> {
    let mut remarks: Vec<String> = saved.remark.iter().cloned().collect();
    let before = &saved.note;
    for (what, old, new) in
        [("the program", &before.version, &now.version), ("the adapter", &before.adapter, &now.adapter)]
    {
        if old != new {
            remarks.push(format!(
                "{what} was {old}, now it is {new}: the run goes on, but not bit by bit as it would have"
            ));
        }
    }
    remarks
}

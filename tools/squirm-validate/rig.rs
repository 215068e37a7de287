//! The opened adapter, and plans from the pipeline files of the cases.

use crate::case::{Size, Trouble};
use squirm::gpu::{Form, Gpu, Session};
use squirm::graph::Plan;
use squirm::state::{State, System};
use std::path::PathBuf;

/// What a case runs on.
pub struct Rig {
    /// The adapter.
    pub gpu: Gpu,
    /// Folder of the pipeline files.
    pub pipelines: PathBuf,
    /// How much work to do.
    pub size: Size,
    /// Spoils every plan: a negative control.
    pub spoil: Option<fn(&mut Plan)>,
}

/// A pipeline file as it was meant, and as it will be run.
#[derive(Debug, Clone)]
pub struct Planned {
    /// What was meant: theory goes by this.
    pub system: System,
    /// What is run; differs in a negative control only.
    pub plan: Plan,
}

impl Rig {
    /// The first, or the second in a full run.
    pub fn pick<T>(&self, quick: T, full: T) -> T {
        if self.size == Size::Full { full } else { quick }
    }

    /// The plan of `pipelines/NAME.toml` with `sets` laid over it like `--set key=value`.
    pub fn plan(&self, name: &str, sets: &[String]) -> Result<Planned, Trouble> {
        let path = self.pipelines.join(name).with_extension("toml");
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let loaded = squirm::config::load(&path.to_string_lossy(), &text, sets, &self.pipelines)?;
        let mut plan = loaded.plan;
        let system = plan.system.clone();
        if let Some(spoil) = self.spoil {
            spoil(&mut plan);
        }
        Ok(Planned { system, plan })
    }

    /// A session that begins with this state, in the form in which users run.
    pub fn session(&self, planned: &Planned, state: &State) -> Result<Session, Trouble> {
        Ok(Session::formed(&self.gpu, &planned.plan, state, Form::Fused)?)
    }

    /// The same with every stage's results in memory, the sums over cells among them.
    pub fn loose_session(&self, planned: &Planned, state: &State) -> Result<Session, Trouble> {
        Ok(Session::new(&self.gpu, &planned.plan, state)?)
    }

    /// The thermal random start of the plan.
    pub fn start(&self, planned: &Planned) -> Result<State, Trouble> {
        Ok(squirm::state::start::start(&planned.plan.system)?)
    }
}

/// Does `steps` steps, in submissions short enough for a driver's watchdog; a kernel's complaint is an error.
pub fn advance(session: &mut Session, steps: u64) -> Result<(), Trouble> {
    let mut left = steps;
    while left > 0 {
        let now = left.min(100);
        session.advance(now, false);
        session.wait()?;
        left -= now;
    }
    Ok(())
}

/// An error if a kernel met something that it could not handle.
pub fn sound(session: &Session) -> Result<(), Trouble> {
    match session.faults()? {
        0 => Ok(()),
        flags => Err(format!("faults {flags:#x} by step {}", session.step()).into()),
    }
}

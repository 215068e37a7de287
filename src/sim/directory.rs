//! The directory of a run: whether it is free, holds a run that goes on, or one that does not.

use super::RunError;
use super::saved::Saved;
use crate::checkpoint::{self, CURRENT, PREVIOUS};
use crate::gpu::Form;
use crate::graph::Plan;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// Files that make a directory a run's.
const FILES: [&str; 8] =
    [CURRENT, PREVIOUS, "run.mcap", "run.fluid.mcap", "summary.json", "pipeline.toml", "scalars.csv", "squirmers.csv"];

/// Whether a new run may write into `dir`; nothing is made yet.
///
/// # Errors
/// If it holds a run, or is no directory.
pub fn check_free(dir: &Path) -> Result<(), RunError> {
    if FILES.iter().any(|name| dir.join(name).exists()) {
        return Err(RunError::Occupied(dir.into()));
    }
    match dir.ancestors().find(|d| d.exists()) {
        Some(there) if !there.is_dir() => Err(RunError::NoDirectory(there.into())),
        _ => Ok(()),
    }
}

/// What goes on in `dir`, if it is a run of this plan; `None` if a new run may begin there.
///
/// # Errors
/// If it holds another run, one that is finished, or one that cannot go on.
pub fn inspect(dir: &Path, plan: &Plan, form: Form, fresh: bool) -> Result<Option<Saved>, RunError> {
    if fresh {
        return match check_free(dir) {
            Err(RunError::Occupied(dir)) => Err(RunError::NotFresh(dir)),
            free => free.map(|()| None),
        };
    }
    let saved = match dir.is_dir() {
        true => Saved::load(dir)?,
        false => None,
    };
    let Some(saved) = saved else { return check_free(dir).map(|()| None) };
    let differences = saved.differences(plan, form);
    if !differences.is_empty() {
        return Err(RunError::Differs { dir: dir.into(), differences });
    }
    let step = saved.note.step;
    if step >= plan.system.run.steps && step > 0 && closed(dir, step) {
        return Err(RunError::Finished { dir: dir.into(), step });
    }
    Ok(Some(saved))
}

/// Whether a run of so many steps came to its end, which its summary is the last to tell. One that was killed after its last step has its outputs
/// still to close.
fn closed(dir: &Path, step: u64) -> bool {
    let Ok(text) = std::fs::read_to_string(dir.join("summary.json")) else { return false };
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    summary["stopped"] == false && summary["speed"]["steps"] == step
}

/// The directory for a run that names none: where the last run of the same configuration is, so that the same command goes on with
/// it; else, or if it is to be `fresh`, the first of `runs/NAME`, `runs/NAME-2` and so on that is free.
#[must_use]
pub fn choose(plan: &Plan, form: Form, fresh: bool) -> PathBuf {
    let name = &plan.name;
    let numbered = |n: u32| PathBuf::from("runs").join(if n == 1 { name.clone() } else { format!("{name}-{n}") });
    let taken: Vec<PathBuf> = (1..).map(numbered).take_while(|dir| dir.exists()).collect();
    let free = numbered(u32::try_from(taken.len()).unwrap_or(u32::MAX).saturating_add(1));
    if fresh {
        return free;
    }
    let same = |dir: &&PathBuf| match inspect(dir, plan, form, false) {
        Ok(going) => going.is_some(),
        Err(RunError::Finished { .. }) => true,
        // Whose it is, is not known by its checkpoints.
        Err(RunError::Checkpoints(_)) => resolved_alike(dir, plan),
        Err(_) => false,
    };
    taken.iter().rev().find(same).cloned().unwrap_or(free)
}

fn resolved_alike(dir: &Path, plan: &Plan) -> bool {
    let text = std::fs::read_to_string(dir.join("pipeline.toml"));
    text.map_or(true, |text| checkpoint::decisive(&text) == checkpoint::decisive(&plan.resolved))
}

/// Keeps other processes out of a directory; the system lets go of it when the process ends, however it ends.
pub struct Claim {
    _directory: Option<File>,
}

/// Claims a directory that is there.
///
/// # Errors
/// If another process has it.
pub fn claim(dir: &Path) -> Result<Claim, RunError> {
    // Where directories or the file system know no locks there is none.
    let Ok(directory) = File::open(dir) else { return Ok(Claim { _directory: None }) };
    match directory.try_lock() {
        Err(TryLockError::WouldBlock) => Err(RunError::Busy(dir.into())),
        Ok(()) => Ok(Claim { _directory: Some(directory) }),
        Err(TryLockError::Error(_)) => Ok(Claim { _directory: None }),
    }
}

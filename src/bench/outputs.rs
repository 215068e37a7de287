//! What outputs cost: whole runs with and without them, by turns.

use super::BenchError;
use super::cases::OUTPUTS_AT_MOST;
use super::report::OutputCost;
use super::statistics::Spread;
use crate::gpu::Form;
use crate::graph::{Output, Plan};
use crate::sim::{self, Options, Watch};
use std::path::{Path, PathBuf};

/// Rounds of runs without and with each kind of output.
const ROUNDS: usize = 3;

/// Every how many steps something leaves.
const EVERY: u64 = 100;

/// A folder that is removed with all its content in the end.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Passes signals on to a run.
struct Silent<'a>(&'a dyn Fn() -> bool);

impl Watch for Silent<'_> {
    fn begin(&mut self, _adapter: &str, _steps: u64) {}
    fn progress(&mut self, _done: u64) {}
    fn stop(&self) -> bool {
        (self.0)()
    }
}

fn output(record: &str, publish: &[&str]) -> Output {
    let publish = publish.iter().map(|s| (*s).to_owned()).collect();
    let on_slow = "drop".into();
    Output {
        publish,
        record: vec![record.into()],
        csv: Vec::new(),
        every: EVERY,
        block: 2,
        fraction: 0.1,
        on_slow,
        slow_limit: 1.0,
    }
}

/// Runs the plan with squirmers recorded, and with a tenth of the fluid published and recorded, each against runs without outputs.
/// Files go into a folder for temporary files. The time is that of the steps, until the GPU has done the last.
///
/// # Errors
/// If a run fails, or `stop` says so.
pub fn outputs(
    (adapter, form): (Option<&str>, Form),
    (case, plan): (&str, &Plan),
    stop: &dyn Fn() -> bool,
) -> Result<Vec<OutputCost>, BenchError> {
    let kinds = [
        ("squirmers recorded", output("squirmers", &[])),
        ("a tenth of the fluid published and recorded", output("particles", &["particles"])),
    ];
    let folder = Folder(std::env::temp_dir().join(format!("squirm-bench-{}", std::process::id())));
    let mut plan = plan.clone();
    plan.name = format!("bench-{}", std::process::id());
    let mut seconds = |number: usize, outputs: Vec<Output>| -> Result<f64, BenchError> {
        plan.outputs = outputs;
        let out = folder.0.join(number.to_string());
        let seconds = run(&plan, &out, (adapter, form), stop)?;
        let _ = std::fs::remove_dir_all(&out);
        Ok(seconds)
    };
    let mut percent = vec![Vec::new(); kinds.len()];
    // The first run finds a cold GPU.
    seconds(0, Vec::new())?;
    for _ in 0..ROUNDS {
        let without = seconds(0, Vec::new())?;
        for (i, (_, output)) in kinds.iter().enumerate() {
            percent[i].push(100.0 * (seconds(1 + i, vec![output.clone()])? / without - 1.0));
        }
    }
    let cost = |(i, (what, _)): (usize, &(&str, Output))| OutputCost {
        case: case.to_owned(),
        what: format!("{what} every {EVERY} steps"),
        steps: plan.system.run.steps,
        percent: Spread::of(&percent[i]).expect("there are rounds"),
        at_most: OUTPUTS_AT_MOST[i],
    };
    Ok(kinds.iter().enumerate().map(cost).collect())
}

fn run(
    plan: &Plan,
    out: &Path,
    (adapter, form): (Option<&str>, Form),
    stop: &dyn Fn() -> bool,
) -> Result<f64, BenchError> {
    let mut plan = plan.clone();
    plan.checkpoints.enabled = false;
    let (out, adapter, command) = (out.to_owned(), adapter.map(str::to_owned), "squirm bench".into());
    let options = Options { out, adapter, command, form, ..Options::default() };
    let summary = sim::run(&plan, &options, &mut Silent(stop))?;
    if summary.stopped { Err(BenchError::Stopped) } else { Ok(summary.speed.seconds) }
}

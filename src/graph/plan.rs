//! The validated plan that configuration produces and the simulation executes.

use crate::analyze::kinds::KINDS;
use crate::params;
use crate::params::{Params, Values};
use crate::stages::Entry;
use crate::state::System;
use std::path::Path;

params! {
    /// What leaves the run, and how often.
    pub struct Output {
        /// Publish these to analyzers on this machine through shared memory.
        pub publish: Vec<String> = Vec::<String>::new(); "", Words(&["squirmers", "scalars", "fields", "particles"]);
        /// Record these into run.mcap (particles into run.fluid.mcap).
        pub record: Vec<String> = Vec::<String>::new(); "", Words(&["squirmers", "scalars", "fields", "particles"]);
        /// Write these as tables, one CSV file each.
        pub csv: Vec<String> = Vec::<String>::new(); "", Words(&["squirmers", "scalars"]);
        /// Every how many steps.
        pub every: u64 = 100u64; "steps", Integer { min: 1, max: 1_000_000_000 };
        /// Edge of the blocks over which fields are averaged.
        pub block: u32 = 2u32; "a", Integer { min: 1, max: 64 };
        /// Share of the fluid particles taken, for `particles`.
        pub fraction: f64 = 0.1; "", Float { min: 0.0, max: 1.0 };
        /// What happens when a reader of `publish` is slower than the run. drop: it loses snapshots, and sees that it did; block: the
        /// run waits for it, up to `slow_limit`, then goes on without it until it has caught up; abort: after `slow_limit` the run ends.
        pub on_slow: String = "drop"; "", Choice(&["drop", "block", "abort"]);
        /// Longest time that the run waits for one reader.
        pub slow_limit: f64 = 10.0; "s", Float { min: 0.1, max: 3600.0 };
    }
}

/// Names of the analyzers that come with the program.
const ANALYZERS: [&str; KINDS.len()] = {
    let mut names = [""; KINDS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = KINDS[i].name;
        i += 1;
    }
    names
};

params! {
    /// A program that reads what the run publishes: started with the run, started again if it dies, ended with the run.
    pub struct AnalyzerProgram {
        /// An analyzer of squirm-analyze.
        pub kind: Option<String>; "", Choice(&ANALYZERS);
        /// Or a program of your own with its arguments. `{run}` in an argument becomes the name of the run, which is also in the
        /// environment variable SQUIRM_RUN; SQUIRM_OUT has the folder that it should write into.
        pub command: Option<Vec<String>>; "", Texts;
        /// Folder for what it writes, inside the folder of the run; the kind or the program's name if left out.
        pub out: Option<String>; "", Text;
    }
}

impl AnalyzerProgram {
    /// What to call it: its kind, or the name of its program.
    #[must_use]
    pub fn name(&self) -> &str {
        let program = self.command.iter().flatten().next().map_or("analyzer", String::as_str);
        let program = Path::new(program).file_stem().and_then(|s| s.to_str()).unwrap_or(program);
        self.kind.as_deref().unwrap_or(program)
    }

    /// Its folder inside the folder of the run.
    #[must_use]
    pub fn folder(&self) -> &str {
        self.out.as_deref().unwrap_or_else(|| self.name())
    }
}

params! {
    /// Checkpoints, from which a run that was ended, killed or cut off goes on.
    pub struct Checkpoints {
        /// Whether to write any; without them a run that ends early cannot go on.
        pub enabled: bool = true; "", Boolean;
        /// Wall time between two; 0 writes none by the clock.
        pub minutes: f64 = 10.0; "min", Float { min: 0.0, max: 100_000.0 };
        /// Also after every so many steps; 0 writes none by steps.
        pub every: u64 = 0u64; "steps", Integer { min: 0, max: i64::MAX };
    }
}

impl Default for Checkpoints {
    fn default() -> Self {
        Self::from_values(&Values::defaults(&Self::fields()))
    }
}

/// One stage of the step with its parsed parameters.
#[derive(Debug, Clone)]
pub struct PlannedStage {
    /// The registry entry.
    pub entry: &'static Entry,
    /// Parameters, complete.
    pub values: Values,
}

/// Everything that a run needs to know, checked.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Name of the run: the stem of the pipeline file.
    pub name: String,
    /// The physical system.
    pub system: System,
    /// The stages of one step, in execution order.
    pub stages: Vec<PlannedStage>,
    /// What leaves the run.
    pub outputs: Vec<Output>,
    /// What is started with it.
    pub analyzers: Vec<AnalyzerProgram>,
    /// When checkpoints are written.
    pub checkpoints: Checkpoints,
    /// The fully resolved pipeline file: every default written out; reads back as the same plan.
    pub resolved: String,
}

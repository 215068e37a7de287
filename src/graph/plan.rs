//! The validated plan that configuration produces and the simulation executes.

use crate::params;
use crate::params::{Params, Values};
use crate::stages::Entry;
use crate::state::System;

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
    /// When checkpoints are written.
    pub checkpoints: Checkpoints,
    /// The fully resolved pipeline file: every default written out; reads back as the same plan.
    pub resolved: String,
}

//! The validated plan that configuration produces and the simulation executes.

use crate::params;
use crate::params::Values;
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
    /// The fully resolved pipeline file: every default written out; reads back as the same plan.
    pub resolved: String,
}

//! The plan of a run: the validated list of stages and outputs over the buffers of the catalogue.

pub mod plan;

pub use plan::{Output, Plan, PlannedStage};

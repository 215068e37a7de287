//! The plan of a run: the validated list of stages and outputs over the buffers of the catalogue.

pub mod beside;
pub mod draw;
pub mod freshness;
pub mod fused;
pub mod in_turn;
pub mod kernels;
pub mod plan;
pub mod sizes;
pub mod small;
pub mod traffic;

pub use kernels::{Kernel, Use, constants, kernels, places};
pub use plan::{AnalyzerProgram, Checkpoints, Output, Plan, PlannedStage};
pub use sizes::{SHOWN, memory, sizes};

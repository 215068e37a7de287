//! Benchmarks: how fast cases run on an adapter, what they ask of its memory, and how two reports differ.

pub mod cases;
mod compare;
mod measure;
mod outputs;
mod report;
mod statistics;
mod table;

pub use cases::{CASES, Case, Kind, Measure};
pub use compare::{Comparison, compare};
pub use measure::{Effort, copy, measure};
pub use outputs::outputs;
pub use report::{CopyRate, Measured, Memory, OutputCost, Report, Skipped, StageCost, Target};
pub use statistics::Spread;
pub use table::{case, header, output};

use crate::gpu::GpuError;
use crate::sim::RunError;

/// Why something could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// What can go wrong in a run, too.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Kernels reported something that would have stopped a run.
    #[error("kernels reported faults ({0:#x}): a run of this pipeline would have been stopped; `squirm run` says why")]
    Faults(u32),
    /// A signal.
    #[error("stopped")]
    Stopped,
}

impl From<GpuError> for BenchError {
    fn from(error: GpuError) -> Self {
        Self::Run(error.into())
    }
}

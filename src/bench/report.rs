//! What a benchmark found, as `--json` writes and `--against` reads it.

use super::statistics::Spread;
use serde::{Deserialize, Serialize};

/// Everything that was measured on one adapter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of the program.
    pub version: String,
    /// Adapter.
    pub adapter: String,
    /// What it is: "GPU", "CPU" and so on.
    pub kind: String,
    /// Its driver.
    pub driver: String,
    /// "fused" or "loose".
    pub plan: String,
    /// The copy that kernels are held against.
    pub copy: CopyRate,
    /// Cases, in the order in which they were measured.
    pub cases: Vec<Measured>,
    /// What outputs cost.
    #[serde(default)]
    pub outputs: Vec<OutputCost>,
    /// Cases that were not measured.
    #[serde(default)]
    pub skipped: Vec<Skipped>,
}

/// A plain copy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CopyRate {
    /// Length of the buffer that was copied.
    pub bytes: u64,
    /// Read and written, in 10^9 bytes per second.
    pub gb_per_s: Spread,
}

/// One case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Its name.
    pub case: String,
    /// What it is.
    pub what: String,
    /// Cells of the box per axis.
    pub size: [u32; 3],
    /// Fluid particles.
    pub particles: u64,
    /// Squirmers.
    pub squirmers: u64,
    /// Steps measured.
    pub steps: u64,
    /// Steps in a batch.
    pub batch: u64,
    /// Wall time of a step in microseconds.
    pub us_per_step: Spread,
    /// Wall time of a step per fluid particle, in nanoseconds.
    pub ns_per_particle_step: Spread,
    /// What it should not exceed on one H100.
    pub target: Option<Target>,
    /// Kernels launched in an average step.
    pub launches: f64,
    /// Bytes per particle that a step must move if every kernel reads and writes each of its buffers once.
    pub bytes_per_particle: f64,
    /// The same in 10^9 bytes per second.
    pub gb_per_s: f64,
    /// The same as a share of the copy.
    pub share_of_copy: f64,
    /// Memory on the GPU.
    pub memory: Memory,
    /// The stages, or those that share a kernel.
    pub stages: Vec<StageCost>,
    /// What a reader should know of how it was measured.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// A target, for one H100.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// In what.
    pub unit: String,
    /// The target.
    pub at_most: f64,
    /// What was measured; absent if the other case of a ratio was not.
    pub measured: Option<f64>,
}

/// What one kernel costs in an average step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageCost {
    /// The stage, or those that share the kernel.
    pub stage: String,
    /// Kernels launched.
    pub launches: f64,
    /// Share of the time of a step, from timestamps; absent if the adapter has none.
    pub share: Option<f64>,
    /// That share of the measured time, per particle, in nanoseconds.
    pub ns_per_particle_step: Option<f64>,
    /// Bytes per particle that it must move.
    pub bytes_per_particle: f64,
    /// The same in 10^9 bytes per second.
    pub gb_per_s: Option<f64>,
    /// The same as a share of the copy.
    pub share_of_copy: Option<f64>,
}

/// Buffers on the GPU.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// All of them, in bytes.
    pub bytes: u64,
    /// Bytes per particle of those that have something for each particle.
    pub per_particle: f64,
    /// Bytes per cell of the box of those that have something for each cell.
    pub per_cell: f64,
    /// Bytes of all others.
    pub others: u64,
}

/// What one kind of output costs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutputCost {
    /// The case.
    pub case: String,
    /// Which output.
    pub what: String,
    /// Steps of each run.
    pub steps: u64,
    /// Additional time in per cent of the time without outputs.
    pub percent: Spread,
    /// What that should not exceed on one H100.
    pub at_most: f64,
}

/// A case that was not measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Skipped {
    /// Its name.
    pub case: String,
    /// Why.
    pub why: String,
}

impl Report {
    /// Whether targets apply: they are for one H100.
    #[must_use]
    pub fn has_targets(&self) -> bool {
        self.adapter.contains("H100")
    }

    /// Reads what `--json` has written.
    ///
    /// # Errors
    /// If it is no JSON, or lacks something, with the place.
    pub fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|e| e.to_string())
    }

    /// As JSON.
    #[must_use]
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a report has no keys that JSON lacks") + "\n"
    }
}

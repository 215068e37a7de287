//! The `status` message: what a run tells about itself about once a second, whatever its outputs say.

use super::encode::message_bytes;
use super::header::padded;
use super::{Encoder, Kind, Scalars, Snapshot, Stamp, WireError};

/// Numbers in a message.
const NUMBERS: usize = 10;
/// Most stages in a message; more are left out.
const STAGES: usize = 32;
/// Texts in a message.
const TEXTS: usize = 3;

/// How a run is, in numbers; step and time stand in the header.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Status {
    /// Process of the run.
    pub pid: u32,
    /// When it began: seconds since 1970.
    pub started: f64,
    /// Steps to do in all; 0 if unknown.
    pub steps: u64,
    /// Steps per second of wall time over the last seconds.
    pub speed: f64,
    /// Fluid particles.
    pub particles: u64,
    /// Temperature of the fluid in kT; NaN while unknown.
    pub temperature: f64,
    /// Mean speed of the squirmers along their axes in sqrt(kT/m); NaN while unknown, or without squirmers.
    pub swim_speed: f64,
    /// Snapshots published.
    pub published: u64,
    /// Snapshots that could not be published, or that a reader was too slow for although the run waited.
    pub dropped: u64,
    /// The longest that publishing one snapshot took since the status before, in seconds; waiting for readers included.
    pub longest_publication: f64,
    /// Mean GPU time of each stage in nanoseconds per step; empty if the adapter has no timestamps.
    pub stages: Vec<(String, f64)>,
    /// What it does: `running`, or how it ended.
    pub phase: String,
    /// Adapter that it runs on.
    pub adapter: String,
    /// Folder that it writes into.
    pub folder: String,
}

impl Status {
    /// The phase of a run that is going.
    pub const RUNNING: &'static str = "running";
    /// The phase of a run that has done all its steps, or was stopped, with its files complete.
    pub const ENDED: &'static str = "ended";

    /// Length of the longest message.
    #[must_use]
    pub fn message_bytes() -> usize {
        let numbers = [32, 16, 8].map(|width| (width, NUMBERS));
        let stages = [64, 8].map(|width| (width, STAGES));
        let texts = [32, 256].map(|width| (width, TEXTS));
        message_bytes(&[&numbers[..], &stages, &texts].concat())
    }

    /// The numbers with names and units, as in a `scalars` message.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn numbers(&self) -> Scalars {
        let mut out = Scalars::default();
        out.push("pid", "", f64::from(self.pid));
        out.push("started", "s since 1970", self.started);
        out.push("steps", "", self.steps as f64);
        out.push("speed", "steps/s", self.speed);
        out.push("particles", "", self.particles as f64);
        out.push("temperature", "kT", self.temperature);
        out.push("swim_speed", "sqrt(kT/m)", self.swim_speed);
        out.push("published", "", self.published as f64);
        out.push("dropped", "", self.dropped as f64);
        out.push("longest_publication", "s", self.longest_publication);
        out
    }

    /// The message.
    #[must_use]
    pub fn encode(&self, stamp: &Stamp) -> Vec<u8> {
        let numbers = self.numbers().list;
        let names: Vec<[u8; 32]> = numbers.iter().map(|s| padded(&s.name)).collect();
        let units: Vec<[u8; 16]> = numbers.iter().map(|s| padded(&s.unit)).collect();
        let values: Vec<f64> = numbers.iter().map(|s| s.value).collect();
        let stages = &self.stages[..self.stages.len().min(STAGES)];
        let stage_names: Vec<[u8; 64]> = stages.iter().map(|s| padded(&s.0)).collect();
        let stage_times: Vec<f64> = stages.iter().map(|s| s.1).collect();
        let texts = [("phase", &self.phase), ("adapter", &self.adapter), ("folder", &self.folder)];
        let text_names: Vec<[u8; 32]> = texts.iter().map(|t| padded(t.0)).collect();
        let text_values: Vec<[u8; 256]> = texts.iter().map(|t| padded(t.1)).collect();
        Encoder::new(Kind::Status, stamp)
            .rows(values.len(), values.len() as u64)
            .column("name", "", &names)
            .column("unit", "", &units)
            .flat("value", "", 1, &values)
            .column("stage.name", "", &stage_names)
            .flat("stage.time", "ns", 1, &stage_times)
            .column("text.name", "", &text_names)
            .column("text.value", "", &text_values)
            .finish()
    }

    /// The status of a message; numbers and texts that it lacks stay zero, unknown or empty.
    ///
    /// # Errors
    /// If it is a message of another kind, or its columns do not fit together.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn decode(snapshot: &Snapshot<'_>) -> Result<Self, WireError> {
        snapshot.expect(Kind::Status)?;
        let (names, values) = (snapshot.texts::<32>("name")?, snapshot.values::<f64>("value")?);
        let (stages, times) = (snapshot.texts::<64>("stage.name")?, snapshot.values::<f64>("stage.time")?);
        let (titles, texts) = (snapshot.texts::<32>("text.name")?, snapshot.texts::<256>("text.value")?);
        if (names.len(), stages.len(), titles.len()) != (values.len(), times.len(), texts.len()) {
            return Err(WireError::Malformed("the status' columns have different lengths".into()));
        }
        let number = |name: &str| names.iter().position(|n| n == name).map(|i| values[i]);
        // Casting saturates: a hostile number becomes a wrong one, no more.
        let count = |name: &str| number(name).unwrap_or(0.0) as u64;
        let text = |name: &str| titles.iter().position(|n| n == name).map_or(String::new(), |i| texts[i].clone());
        Ok(Self {
            pid: count("pid") as u32,
            started: number("started").unwrap_or(f64::NAN),
            steps: count("steps"),
            speed: number("speed").unwrap_or(0.0),
            particles: count("particles"),
            temperature: number("temperature").unwrap_or(f64::NAN),
            swim_speed: number("swim_speed").unwrap_or(f64::NAN),
            published: count("published"),
            dropped: count("dropped"),
            longest_publication: number("longest_publication").unwrap_or(0.0),
            stages: stages.into_iter().zip(times).collect(),
            phase: text("phase"),
            adapter: text("adapter"),
            folder: text("folder"),
        })
    }
}

//! What a run has left: its final state, every frame of its recordings, its tables.

use squirm::analyze::{Recording, Source};
use squirm::wire::{Kind, Particles, Snapshot};
use std::ops::ControlFlow;
use std::path::Path;

/// One recorded snapshot: its kind, step and number, and a hash of what it shows.
pub type Frame = (Kind, u64, u64, [u8; 32]);

/// All of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Left {
    /// Digest of the final state.
    pub digest: String,
    /// Books in the summary.
    pub books: String,
    /// Frames in the order of the recordings.
    pub frames: Vec<Frame>,
    /// Contents of the tables.
    pub tables: Vec<Vec<u8>>,
}

/// Every frame of a run's recordings, which must be complete.
pub fn frames(dir: &Path) -> Result<Vec<Frame>, String> {
    let mut frames = Vec::new();
    let mut visit = |snapshot: &Snapshot<'_>| {
        let header = &snapshot.header;
        frames.push((snapshot.kind(), header.step, header.seq, shown(snapshot)));
        Ok(ControlFlow::Continue(()))
    };
    let ending = Recording::new(dir).drive(&Kind::ALL, &mut visit).map_err(|e| e.to_string())?;
    match ending.warnings.into_iter().next() {
        Some(warning) => Err(warning),
        None => Ok(frames),
    }
}

/// A hash of what a snapshot shows. The identity of the run, and the checksum of the header that has it, are left out; particles
/// count in any order, since that in memory means nothing.
fn shown(snapshot: &Snapshot<'_>) -> [u8; 32] {
    let mut bytes = snapshot.bytes().to_vec();
    bytes[16..32].fill(0);
    bytes[156..160].fill(0);
    if let (Kind::Particles, Ok(particles)) = (snapshot.kind(), Particles::decode(snapshot)) {
        let one = |i: usize| format!("{:?} {:?}", particles.place(i), particles.velocity[i]);
        let mut rows: Vec<String> = (0..particles.velocity.len()).map(one).collect();
        rows.sort_unstable();
        bytes = rows.concat().into_bytes();
    }
    *blake3::hash(&bytes).as_bytes()
}

/// What a finished run has left in `dir`.
pub fn left(dir: &Path) -> Result<Left, String> {
    let text = |name: &str| std::fs::read_to_string(dir.join(name)).map_err(|e| format!("{name}: {e}"));
    let summary: serde_json::Value = serde_json::from_str(&text("summary.json")?).map_err(|e| e.to_string())?;
    let known = ["temperature", "swim_speed", "books", "snapshots", "stopped"].map(|key| summary[key].to_string());
    let tables = ["scalars.csv", "squirmers.csv"].map(|name| text(name).map(String::into_bytes));
    Ok(Left {
        digest: summary["digest"].as_str().unwrap_or_default().to_owned(),
        books: known.join(" "),
        frames: frames(dir)?,
        tables: tables.into_iter().collect::<Result<_, _>>()?,
    })
}

/// What of `expected` is not as it should be.
pub fn compare(left: &Left, expected: &Left) -> Result<(), String> {
    if left.digest != expected.digest {
        return Err(format!("the state is {}, not {}", left.digest, expected.digest));
    }
    let steps = |frames: &[Frame]| frames.iter().map(|(k, step, seq, _)| (*k, *step, *seq)).collect::<Vec<_>>();
    let (found, wanted) = (steps(&left.frames), steps(&expected.frames));
    if let Some(missing) = wanted.iter().find(|f| !found.contains(f)) {
        return Err(format!("frame {missing:?} is missing"));
    }
    if let Some(more) = found.iter().enumerate().find(|(i, f)| found[..*i].contains(f) || !wanted.contains(f)) {
        return Err(format!("frame {:?} is there twice", more.1));
    }
    if found != wanted {
        return Err("the frames are in another order".into());
    }
    if let Some(other) = left.frames.iter().zip(&expected.frames).find(|(a, b)| a != b) {
        return Err(format!(
            "frame {:?} shows something else",
            &found[left.frames.iter().position(|f| f == other.0).unwrap_or(0)]
        ));
    }
    if left.tables != expected.tables {
        return Err("the tables differ".into());
    }
    if left.books != expected.books {
        return Err(format!("the summary says {}, not {}", left.books, expected.books));
    }
    Ok(())
}

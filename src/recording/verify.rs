//! Whether a recording is whole: every checksum, every snapshot, and that none is missing or out of order.

use super::provenance::{METADATA, Provenance};
use super::scan::{Chunk, Part, Scan};
use super::series::THINNED;
use super::{RecordingError, TOPICS, recordings};
use crate::wire::{Header, Kind, Snapshot};
use mcap::records::{MessageHeader, Metadata};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// Something that is not as it should be.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Finding {
    /// The file.
    pub path: PathBuf,
    /// Where in it, in bytes; none if it concerns no single place.
    pub at: Option<u64>,
    /// What is wrong.
    pub what: String,
}

impl Finding {
    /// A finding at a place.
    #[must_use]
    pub fn new(path: &Path, at: Option<u64>, what: String) -> Self {
        Self { path: path.into(), at, what }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some(at) => write!(f, "{}, byte {at}: {}", self.path.display(), self.what),
            None => write!(f, "{}: {}", self.path.display(), self.what),
        }
    }
}

/// What was checked and found.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Verdict {
    /// Files read.
    pub files: Vec<PathBuf>,
    /// Chunks whose checksums are right.
    pub chunks: u64,
    /// Snapshots whose headers and checksums are right.
    pub snapshots: u64,
    /// Everything that is wrong; empty for a clean recording.
    pub findings: Vec<Finding>,
}

/// The newest snapshot of one output.
#[derive(Clone, Copy)]
struct Last {
    step: u64,
    time: f64,
    seq: u64,
    earlier: bool,
}

/// Reading, and what was seen so far.
#[derive(Default)]
struct Check {
    verdict: Verdict,
    last: BTreeMap<(Kind, u64), Last>,
    run_id: Option<[u8; 16]>,
    thinned: bool,
    gaps: Vec<Finding>,
}

/// Checks a recording with all of its segments; of a run's folder that of the fluid, too.
///
/// # Errors
/// If a file cannot be read, or is no recording at all.
pub fn verify(path: &Path) -> Result<Verdict, RecordingError> {
    let mut check = Check::default();
    for files in recordings(path)? {
        check.recording(files)?;
    }
    Ok(check.verdict)
}

impl Check {
    /// One recording of a run; all of them have the run's identity.
    fn recording(&mut self, files: Vec<PathBuf>) -> Result<(), RecordingError> {
        self.last.clear();
        self.thinned = false;
        for file in &files {
            self.last.values_mut().for_each(|last| last.earlier = true);
            self.file(file)?;
        }
        self.verdict.files.extend(files);
        let gaps = std::mem::take(&mut self.gaps);
        // A file that left snapshots out on purpose lacks them rightly.
        if !self.thinned {
            self.verdict.findings.extend(gaps);
        }
        Ok(())
    }

    fn file(&mut self, path: &Path) -> Result<(), RecordingError> {
        let mut scan = Scan::open(path)?;
        let (mut chunks, mut messages) = (0, 0);
        let (mut provenance, mut described) = (None, None);
        while let Some(part) = scan.next_part()? {
            match part {
                Part::Chunk(chunk) => {
                    chunks += 1;
                    messages += self.chunk(&chunk, &scan);
                }
                Part::Attachment(attachment) => provenance = provenance.or_else(|| Provenance::of(&attachment)),
                Part::Metadata(metadata) => {
                    self.thinned |= metadata.name == THINNED;
                    described = described.or_else(|| (metadata.name == METADATA).then_some(metadata));
                }
                Part::Damaged { at, what, .. } => self.found(path, Some(at), what),
                Part::Cut { at, .. } => {
                    let what = "what is whole ends here; the run was killed or is still going".into();
                    self.found(path, Some(at), what);
                }
                Part::End { flaw: Some(flaw) } => self.found(path, None, flaw),
                Part::End { flaw: None } => {}
            }
        }
        self.verdict.chunks += chunks;
        if let (Some(provenance), Some(mut metadata)) = (provenance, described)
            && provenance.mend(&mut metadata)
        {
            self.found(path, None, format!("the metadata `{METADATA}` do not agree with provenance.json"));
        }
        if let Some(stated) = scan.statistics().cloned() {
            let there = (u64::from(stated.chunk_count), stated.message_count);
            if there != (chunks, messages) {
                let (c, m) = there;
                let what =
                    format!("{chunks} chunks with {messages} messages are whole, of {c} with {m} that its end states");
                self.found(path, None, what);
            }
        }
        Ok(())
    }

    fn found(&mut self, path: &Path, at: Option<u64>, what: String) {
        self.verdict.findings.push(Finding::new(path, at, what));
    }

    /// Checks a whole chunk; returns how many messages it has.
    fn chunk(&mut self, chunk: &Chunk, scan: &Scan) -> u64 {
        let (mut count, mut times) = (0, None::<(u64, u64)>);
        for (message, bytes) in chunk.messages() {
            count += 1;
            let time = message.log_time;
            times = Some(times.map_or((time, time), |(a, b)| (a.min(time), b.max(time))));
            let Some(topic) = scan.channels().topic(message.channel_id) else {
                self.found(scan.path(), Some(chunk.at), format!("channel {} is declared nowhere", message.channel_id));
                continue;
            };
            let Some(kind) = topic.strip_prefix(TOPICS).and_then(Kind::from_topic) else { continue };
            match Snapshot::parse(bytes).and_then(|s| s.expect(kind).map(|()| s.header)) {
                Ok(header) => {
                    self.verdict.snapshots += 1;
                    let wrong = self.order(kind, &header, &message, scan.path(), chunk.at);
                    wrong.into_iter().for_each(|what| self.found(scan.path(), Some(chunk.at), what));
                }
                Err(error) => self.found(scan.path(), Some(chunk.at), error.to_string()),
            }
        }
        if times.is_some_and(|times| times != chunk.times) {
            self.found(scan.path(), Some(chunk.at), "the chunk's head states other times than its messages".into());
        }
        count
    }

    /// Whether a snapshot follows the one before.
    fn order(&mut self, kind: Kind, header: &Header, message: &MessageHeader, path: &Path, at: u64) -> Vec<String> {
        let mut wrong = Vec::new();
        let (topic, step) = (kind.topic(), header.step);
        if *self.run_id.get_or_insert(header.run_id) != header.run_id {
            wrong.push(format!("the snapshot of {topic} at step {step} comes from another run"));
        }
        #[allow(clippy::cast_precision_loss)]
        let logged = message.log_time as f64 * 1e-9;
        if (logged - header.time).abs() > 1e-9 + 1e-12 * header.time.abs() {
            wrong.push(format!(
                "the snapshot of {topic} at step {step} is logged at {logged} instead of {}",
                header.time
            ));
        }
        let key = (kind, header.every);
        let new = Last { step, time: header.time, seq: header.seq, earlier: false };
        let Some(last) = self.last.get(&key).copied() else {
            self.last.insert(key, new);
            return wrong;
        };
        if step <= last.step || header.time <= last.time || header.seq <= last.seq {
            // A resumed run repeats what it had made since its checkpoint.
            if !last.earlier {
                wrong.push(format!("the snapshot of {topic} at step {step} comes after that at step {}", last.step));
            }
            return wrong;
        }
        if header.seq > last.seq + 1 {
            let (missing, before) = (header.seq - last.seq - 1, last.step);
            let what = format!("{missing} snapshots of {topic} between steps {before} and {step} are missing");
            self.gaps.push(Finding::new(path, Some(at), what));
        }
        self.last.insert(key, new);
        wrong
    }
}

/// Metadata of a run out of what a file has of it: from the attachment where there is one, for it has a checksum.
pub(super) fn identity(key: &str, provenance: Option<&Provenance>, metadata: Option<&Metadata>) -> Option<String> {
    let stated = || metadata.and_then(|m| m.metadata.get(key).cloned());
    provenance.and_then(|p| p.get(key)).or_else(stated)
}

//! What a recording holds.

use super::provenance::{METADATA, Provenance};
use super::scan::{Chunk, Part, Scan};
use super::verify::{Finding, identity};
use super::{RecordingError, TOPICS, recordings};
use crate::wire::{Kind, Snapshot};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A recording with all of its segments; of a run's folder that of the fluid, too.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Info {
    /// Name of the run.
    pub run: Option<String>,
    /// Its identity, hexadecimal.
    pub run_id: Option<String>,
    /// Its seed.
    pub seed: Option<String>,
    /// Version of the program that recorded it.
    pub version: Option<String>,
    /// Files in order.
    pub files: Vec<FileInfo>,
    /// Topics by name.
    pub topics: BTreeMap<String, TopicInfo>,
    /// Attachments by name, with their lengths in bytes.
    pub attachments: BTreeMap<String, u64>,
    /// Box edges in a.
    pub box_size: Option<[f64; 3]>,
    /// Bytes of all chunks before and after compression.
    pub uncompressed: u64,
    /// Bytes of all chunks in the files.
    pub compressed: u64,
    /// What is wrong; `squirm verify` looks closer.
    pub findings: Vec<Finding>,
}

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct FileInfo {
    /// Where it is.
    pub path: PathBuf,
    /// Its length in bytes.
    pub bytes: u64,
    /// Whole chunks.
    pub chunks: u64,
    /// Whether it has its end.
    pub complete: bool,
}

/// One topic.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct TopicInfo {
    /// Messages.
    pub count: u64,
    /// Bytes of its messages before compression.
    pub bytes: u64,
    /// Encoding of its messages.
    pub encoding: String,
    /// First and last step; only of snapshots.
    pub steps: Option<[u64; 2]>,
    /// First and last time in tau.
    pub time: [f64; 2],
}

/// Reads a recording from beginning to end.
///
/// # Errors
/// If a file cannot be read, or is no recording at all.
pub fn info(path: &Path) -> Result<Info, RecordingError> {
    let mut info = Info::default();
    for file in recordings(path)?.into_iter().flatten() {
        info.file(&file)?;
    }
    Ok(info)
}

impl Info {
    fn file(&mut self, path: &Path) -> Result<(), RecordingError> {
        let mut scan = Scan::open(path)?;
        let (mut chunks, mut complete) = (0, false);
        let (mut provenance, mut metadata) = (None, None);
        while let Some(part) = scan.next_part()? {
            match part {
                Part::Chunk(chunk) => {
                    chunks += 1;
                    self.chunk(&chunk, &scan);
                }
                Part::Attachment(attachment) => {
                    provenance = provenance.or_else(|| Provenance::of(&attachment));
                    self.attachments.insert(attachment.name, attachment.data.len() as u64);
                }
                Part::Metadata(m) => metadata = metadata.or_else(|| (m.name == METADATA).then_some(m)),
                Part::Damaged { at, what, .. } => self.findings.push(Finding::new(path, Some(at), what)),
                Part::Cut { at, .. } => {
                    self.findings.push(Finding::new(path, Some(at), "what is whole ends here".into()));
                }
                Part::End { flaw } => {
                    complete = true;
                    self.findings.extend(flaw.map(|what| Finding::new(path, None, what)));
                }
            }
        }
        for (key, slot) in [
            ("run", &mut self.run),
            ("run_id", &mut self.run_id),
            ("seed", &mut self.seed),
            ("version", &mut self.version),
        ] {
            *slot = slot.take().or_else(|| identity(key, provenance.as_ref(), metadata.as_ref()));
        }
        self.files.push(FileInfo { path: path.into(), bytes: scan.size(), chunks, complete });
        Ok(())
    }

    fn chunk(&mut self, chunk: &Chunk, scan: &Scan) {
        self.uncompressed += chunk.uncompressed();
        self.compressed += chunk.length;
        for (message, bytes) in chunk.messages() {
            let Some(channel) = scan.channels().channels.get(&message.channel_id) else { continue };
            #[allow(clippy::cast_precision_loss)]
            let mut time = message.log_time as f64 * 1e-9;
            let mut step = None;
            if channel.topic.strip_prefix(TOPICS).and_then(Kind::from_topic).is_some() {
                match Snapshot::parse(bytes) {
                    Ok(snapshot) => {
                        (step, time) = (Some(snapshot.header.step), snapshot.header.time);
                        self.box_size.get_or_insert(snapshot.header.box_size);
                    }
                    Err(e) => self.findings.push(Finding::new(scan.path(), Some(chunk.at), e.to_string())),
                }
            }
            let fresh =
                || TopicInfo { time: [time; 2], encoding: channel.message_encoding.clone(), ..TopicInfo::default() };
            let topic = self.topics.entry(channel.topic.clone()).or_insert_with(fresh);
            topic.count += 1;
            topic.bytes += bytes.len() as u64;
            topic.time = [topic.time[0].min(time), topic.time[1].max(time)];
            if let Some(step) = step {
                let [first, last] = topic.steps.unwrap_or([step; 2]);
                topic.steps = Some([first.min(step), last.max(step)]);
            }
        }
    }
}

//! Snapshots out of a recording: a linear scan with every checksum verified.
//!
//! An index would be faster to seek in, but reading by index checks no checksum and does not work for a run that was
//! killed. Small topics have a file of their own, so that the scan is short.

use super::{AnalyzeError, Ending, Source, Visit};
use crate::segments;
use crate::wire::{Kind, Snapshot};
use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Longest chunk that is believed; damaged lengths would otherwise ask for any amount of memory.
const LONGEST: usize = 1 << 33;
/// How much is read at a time, whatever a length that may be damaged asks for.
const READ: usize = 1 << 20;

/// A recording with snapshots: its MCAP files, one after the other.
#[derive(Debug, Clone)]
pub struct Recording {
    segments: Vec<PathBuf>,
}

impl Recording {
    /// The recording at `path`, or `run.mcap` in that folder, with the segments that a resumed run has added.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self { segments: segments::of(path) }
    }
}

impl Source for Recording {
    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError> {
        let mut all = Ending::default();
        let mut going = true;
        for path in &self.segments {
            if !going {
                break;
            }
            let mut visit = |snapshot: &Snapshot<'_>| {
                let flow = visit(snapshot)?;
                going = flow.is_continue();
                Ok(flow)
            };
            let ending = Segment(path, all.snapshots).drive(topics, &mut visit)?;
            all.snapshots += ending.snapshots;
            all.warnings.extend(ending.warnings);
        }
        Ok(all)
    }
}

/// One file of a recording, and how many snapshots there were in those before it.
struct Segment<'a>(&'a Path, u64);

impl Source for Segment<'_> {
    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError> {
        let mut file = File::open(self.0).map_err(AnalyzeError::io(self.0))?;
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(LONGEST);
        let mut reader = LinearReader::new_with_options(options);
        let (mut ending, mut at_end) = (Ending::default(), false);
        let mut channels: HashMap<u16, Kind> = HashMap::new();
        while let Some(event) = reader.next_event() {
            let record = match event {
                Ok(LinearReadEvent::ReadRequest(n)) => {
                    let n = n.clamp(1, READ);
                    let read = file.read(reader.insert(n)).map_err(AnalyzeError::io(self.0))?;
                    at_end = read == 0;
                    reader.notify_read(read);
                    continue;
                }
                // Only what the file's end cut off is forgiven, and not without a word.
                Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) if at_end && self.1 + ending.snapshots > 0 => {
                    let after = ending.snapshots;
                    let path = self.0.display();
                    ending.warnings.push(format!(
                        "{path} ends in the middle: the run was killed or is still going; read {after} whole snapshots"
                    ));
                    return Ok(ending);
                }
                event => event.and_then(|event| match event {
                    LinearReadEvent::Record { data, opcode: opcode @ (op::CHANNEL | op::MESSAGE) } => {
                        mcap::parse_record(opcode, data).map(Some)
                    }
                    _ => Ok(None),
                }),
            };
            match record.map_err(|source| AnalyzeError::Damaged { path: self.0.into(), source })? {
                Some(Record::Channel(channel)) => {
                    let kind = channel.topic.strip_prefix("/squirm/").and_then(Kind::from_topic);
                    if let Some(kind) = kind.filter(|k| topics.contains(k)) {
                        channels.insert(channel.id, kind);
                    }
                }
                Some(Record::Message { header, data }) if channels.contains_key(&header.channel_id) => {
                    let snapshot = Snapshot::parse(&data)?;
                    snapshot.expect(channels[&header.channel_id])?;
                    ending.snapshots += 1;
                    if visit(&snapshot)?.is_break() {
                        return Ok(ending);
                    }
                }
                _ => {}
            }
        }
        Ok(ending)
    }
}

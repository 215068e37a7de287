//! Segments of one run as one file.

use super::copy::Copy;
use super::cut::strict;
use super::scan::{Part, Scan};
use super::{Cut, RecordingError, TOPICS};
use crate::wire::{Kind, Snapshot};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where a file stands among the segments of its run.
struct Segment {
    path: PathBuf,
    run_id: [u8; 16],
    step: u64,
}

/// Copies the segments `files` of one run into the new file `out`, in the order of their first steps; a snapshot that a resumed run
/// made once more is taken once.
///
/// # Errors
/// If two files come from different runs, at damage, or if `out` exists or cannot be written.
pub fn merge(files: &[PathBuf], out: &Path) -> Result<Cut, RecordingError> {
    let mut segments = files.iter().map(|f| first(f)).collect::<Result<Vec<_>, _>>()?;
    segments.sort_by_key(|s| s.step);
    for pair in segments.windows(2) {
        if pair[0].run_id != pair[1].run_id {
            let why = format!("they come from different runs ({} and {})", hex(pair[0].run_id), hex(pair[1].run_id));
            return Err(RecordingError::Foreign { first: pair[0].path.clone(), second: pair[1].path.clone(), why });
        }
    }
    let mut copy = Copy::create(out)?;
    let (mut done, mut joint) = (Cut::default(), Joint::default());
    for segment in &segments {
        joint.last.values_mut().for_each(|last| last.2 = true);
        append(&segment.path, &mut copy, &mut joint, &mut done)?;
    }
    done.messages = copy.finish()?;
    if joint.missing > 0 {
        done.warnings.push(format!("{} snapshots of the run are in none of the files", joint.missing));
    }
    Ok(done)
}

/// What the files before have.
#[derive(Default)]
struct Joint {
    /// The newest time of each output, in ns, its number, and whether it is in an earlier file.
    last: BTreeMap<(String, u64), (u64, u64, bool)>,
    missing: u64,
}

impl Joint {
    /// Whether a message is new; `every` tells outputs of one topic apart.
    fn takes(&mut self, topic: &str, every: u64, time: u64, seq: u64) -> bool {
        let key = (topic.to_owned(), every);
        if let Some((last, before, earlier)) = self.last.get(&key) {
            if *earlier && time <= *last {
                return false;
            }
            if topic.starts_with(TOPICS) {
                self.missing += seq.saturating_sub(before + 1);
            }
        }
        self.last.insert(key, (time, seq, false));
        true
    }
}

fn append(file: &Path, copy: &mut Copy, joint: &mut Joint, done: &mut Cut) -> Result<(), RecordingError> {
    let mut scan = Scan::open(file)?;
    while let Some(part) = scan.next_part()? {
        match part {
            Part::Chunk(chunk) => {
                for (header, bytes) in chunk.messages() {
                    let channels = scan.channels();
                    let Some(channel) = channels.channels.get(&header.channel_id) else { continue };
                    let own = channel.topic.starts_with(TOPICS);
                    let (mut every, mut seq) = (0, u64::from(header.sequence));
                    if own {
                        let wire = |source| RecordingError::Wire { path: file.into(), at: chunk.at, source };
                        let snapshot = Snapshot::parse(bytes).map_err(wire)?;
                        (every, seq) = (snapshot.header.every, snapshot.header.seq);
                    }
                    if joint.takes(&channel.topic, every, header.log_time, seq) {
                        done.snapshots += u64::from(own);
                        copy.message(header, bytes, channels, channel)?;
                    }
                }
                copy.end_chunk()?;
            }
            Part::Attachment(attachment) => copy.attach(attachment)?,
            Part::Metadata(metadata) => copy.describe(&metadata)?,
            part => done.warnings.extend(strict(file, part)?),
        }
    }
    Ok(())
}

/// The first snapshot of a file tells its run and its place.
fn first(file: &Path) -> Result<Segment, RecordingError> {
    let mut scan = Scan::open(file)?;
    while let Some(part) = scan.next_part()? {
        let Part::Chunk(chunk) = part else {
            strict(file, part)?;
            continue;
        };
        for (message, bytes) in chunk.messages() {
            let topic = scan.channels().topic(message.channel_id).unwrap_or_default();
            if topic.strip_prefix(TOPICS).and_then(Kind::from_topic).is_some() {
                let wire = |source| RecordingError::Wire { path: file.into(), at: chunk.at, source };
                let header = Snapshot::parse(bytes).map_err(wire)?.header;
                return Ok(Segment { path: file.into(), run_id: header.run_id, step: header.step });
            }
        }
    }
    Err(RecordingError::Empty(file.into()))
}

fn hex(id: [u8; 16]) -> String {
    id.iter().map(|b| format!("{b:02x}")).collect()
}

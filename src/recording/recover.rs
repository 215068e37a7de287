//! Making a complete file from what is whole in a damaged one.

use super::copy::{Copy, own_channel};
use super::scan::{Channels, Chunk, Part, Scan};
use super::verify::Finding;
use super::{Provenance, RecordingError};
use crate::wire::Snapshot;
use std::path::Path;

/// What was saved, and what was not.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recovered {
    /// Chunks copied.
    pub chunks: u64,
    /// Messages copied.
    pub messages: u64,
    /// Messages that the damaged file says it had; unknown where its end is missing.
    pub stated: Option<u64>,
    /// Attachments copied.
    pub attachments: u64,
    /// What was wrong, in the order of the file.
    pub findings: Vec<Finding>,
    /// Whether anything was lost.
    pub lossy: bool,
}

/// Copies all whole chunks, attachments and metadata of `path` into the new file `out`.
///
/// # Errors
/// If there is nothing to save, `path` cannot be read, or `out` exists or cannot be written.
pub fn recover(path: &Path, out: &Path) -> Result<Recovered, RecordingError> {
    let mut scan = Scan::open(path)?;
    let mut copy = Copy::create(out)?;
    let stated = scan.statistics().map(|s| s.message_count);
    let mut done = Recovered { stated, ..Recovered::default() };
    let (mut provenance, mut described, mut trusted) = (None, Vec::new(), false);
    while let Some(part) = scan.next_part()? {
        match part {
            Part::Chunk(chunk) => {
                done.chunks += 1;
                copy_chunk(&chunk, scan.channels(), &mut copy, &mut done)?;
            }
            Part::Attachment(attachment) => {
                done.attachments += 1;
                provenance = provenance.or_else(|| Provenance::of(&attachment));
                copy.attach(attachment)?;
            }
            Part::Metadata(metadata) => described.push(metadata),
            Part::Damaged { at, what, messages } => {
                // An attachment that is lost is a loss, too.
                done.lossy = true;
                let rest = if messages { "" } else { "; no snapshot was there" };
                done.findings.push(Finding::new(path, Some(at), format!("{what}{rest}")));
            }
            Part::Cut { at, messages } => {
                done.lossy |= messages;
                let what =
                    if messages { "the file ends in the middle of a chunk" } else { "the file's end is missing" };
                done.findings.push(Finding::new(path, Some(at), what.into()));
            }
            Part::End { flaw } => {
                trusted = flaw.is_none();
                done.findings.extend(flaw.map(|what| Finding::new(path, None, what)));
            }
        }
    }
    for mut metadata in described {
        // No checksum is left that protects metadata; what made the recording is written a second time, with one.
        if let Some(provenance) = provenance.as_ref().filter(|_| !trusted)
            && provenance.mend(&mut metadata)
        {
            let what = format!("the metadata `{}` were damaged and are mended from provenance.json", metadata.name);
            done.findings.push(Finding::new(path, None, what));
        }
        copy.describe(&metadata)?;
    }
    if done.messages == 0 {
        return Err(RecordingError::Empty(path.into()));
    }
    done.lossy |= stated.is_some_and(|stated| done.messages < stated);
    copy.finish()?;
    Ok(done)
}

/// Copies a chunk as one chunk. The first one declares the channels: if it is lost and the file's end, too, our own messages still
/// say what they are; those for viewers do not.
fn copy_chunk(chunk: &Chunk, channels: &Channels, copy: &mut Copy, done: &mut Recovered) -> Result<(), RecordingError> {
    for (header, bytes) in chunk.messages() {
        if let Some(channel) = channels.channels.get(&header.channel_id) {
            copy.message(header, bytes, channels, channel)?;
        } else if let Ok(snapshot) = Snapshot::parse(bytes) {
            let (channels, channel) = own_channel(snapshot.kind());
            copy.message(header, bytes, &channels, &channel)?;
        } else {
            done.lossy = true;
            continue;
        }
        done.messages += 1;
    }
    copy.end_chunk()
}

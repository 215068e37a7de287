//! What a complete file says at its end: channels and counts, believed only if their checksum is right.

use super::scan::Channels;
use super::shape::{Bytes, head, is_whole};
use mcap::records::{Record, Statistics, op};
use std::io::{Read, Seek, SeekFrom};

/// Length of a footer record and the magic behind it.
pub(super) const TAIL: u64 = 9 + 20 + 8;

/// The end of a file.
#[derive(Debug, Clone, Default)]
pub(super) struct Summary {
    /// Whether the file ends as a finished one does.
    pub finished: bool,
    /// Whether what stands between data and end matches its checksum; nothing below is filled in otherwise.
    pub intact: bool,
    /// Channels and their schemas.
    pub channels: Channels,
    /// Counts.
    pub statistics: Option<Statistics>,
}

/// Reads the end of a file of `size` bytes.
pub(super) fn summary<R: Read + Seek>(file: &mut R, size: u64) -> std::io::Result<Summary> {
    let mut summary = Summary::default();
    let Some(tail) = size.checked_sub(TAIL) else { return Ok(summary) };
    file.seek(SeekFrom::Start(tail))?;
    let mut end = [0; 37];
    file.read_exact(&mut end)?;
    summary.finished = end[29..] == *mcap::MAGIC && head(&end) == Some((op::FOOTER, 20));
    let mut footer = Bytes(&end[9..29]);
    let (start, _, stored) = (footer.u64().unwrap_or(0), footer.u64(), footer.u32().unwrap_or(0));
    // 0 stands for no summary, which squirm never writes.
    if !summary.finished || start < 8 || start >= tail {
        return Ok(summary);
    }
    file.seek(SeekFrom::Start(start))?;
    let mut bytes = Vec::new();
    file.by_ref().take(tail - start).read_to_end(&mut bytes)?;
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bytes);
    crc.update(&end[..25]);
    if crc.finalize() != stored {
        return Ok(summary);
    }
    summary.intact = true;
    let mut rest = Bytes(&bytes);
    while let Some((opcode, body)) = record(&mut rest).filter(|(opcode, body)| is_whole(*opcode, body)) {
        match mcap::parse_record(opcode, body) {
            Ok(Record::Statistics(statistics)) => summary.statistics = Some(statistics),
            Ok(record) => summary.channels.learn(&record),
            Err(_) => {}
        }
    }
    Ok(summary)
}

/// The next record of a piece of memory.
pub(super) fn record<'a>(rest: &mut Bytes<'a>) -> Option<(u8, &'a [u8])> {
    let mut ahead = Bytes(rest.0);
    let (opcode, len) = head(ahead.take(9)?)?;
    let body = ahead.take(usize::try_from(len).ok()?)?;
    *rest = ahead;
    Some((opcode, body))
}

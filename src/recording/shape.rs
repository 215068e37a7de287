//! Lengths that every record of a data section states twice: what a damaged length, or a place amid other bytes, does not pass.

use mcap::records::op;
use std::io::{Read, Seek, SeekFrom};

/// Opcode and length.
pub(super) const HEAD: u64 = 9;
/// Bytes of a chunk before the name of its compression.
const CHUNK: usize = 32;
/// How much is searched at a time.
const WINDOW: usize = 1 << 20;
/// Longest beginning of a record that [`fits`] looks at.
const LOOK: usize = 512;

/// Reads little-endian numbers and strings without ever leaving its bytes.
pub(super) struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    pub fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(taken)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.take(4).map(|b| u32::from_le_bytes(b.try_into().expect("4 bytes")))
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.take(8).map(|b| u64::from_le_bytes(b.try_into().expect("8 bytes")))
    }

    fn string(&mut self) -> Option<&'a [u8]> {
        let n = self.u32()? as usize;
        self.take(n).filter(|s| std::str::from_utf8(s).is_ok())
    }
}

/// Opcode and length of a record.
pub(super) fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let mut bytes = Bytes(bytes);
    Some((bytes.take(1)?[0], bytes.u64()?))
}

/// Whether a record that may stand in a data section and begins with `body` can be `len` bytes long: `body` may be cut after
/// [`LOOK`] bytes. Records that no checksum protects and that squirm does not write there (channels, messages, private ones) do not pass.
pub(super) fn fits(opcode: u8, len: u64, body: &[u8]) -> bool {
    let stated = match opcode {
        op::HEADER => strings(body, 0, 2),
        op::CHUNK => chunk(body),
        op::MESSAGE_INDEX => Bytes(body.get(2..).unwrap_or_default()).u32().map(|n| 6 + u64::from(n)),
        op::ATTACHMENT => attachment(body),
        op::METADATA => metadata(body),
        op::DATA_END => Some(4),
        _ => None,
    };
    stated == Some(len)
}

fn strings(body: &[u8], skip: usize, count: usize) -> Option<u64> {
    let mut rest = Bytes(body);
    rest.take(skip)?;
    for _ in 0..count {
        rest.string()?;
    }
    Some((body.len() - rest.0.len()) as u64)
}

fn chunk(body: &[u8]) -> Option<u64> {
    let before = strings(body, CHUNK - 4, 1)?;
    let compressed = Bytes(body.get(usize::try_from(before).ok()?..)?).u64()?;
    (before + 8).checked_add(compressed)
}

fn attachment(body: &[u8]) -> Option<u64> {
    let before = strings(body, 16, 2)?;
    let data = Bytes(body.get(usize::try_from(before).ok()?..)?).u64()?;
    (before + 8 + 4).checked_add(data)
}

fn metadata(body: &[u8]) -> Option<u64> {
    let name = strings(body, 0, 1)?;
    let map = Bytes(body.get(usize::try_from(name).ok()?..)?).u32()?;
    // The map is longer than what a search looks at, but it must begin with a string.
    let first = usize::try_from(name).ok()? + 4;
    (map == 0 || strings(body.get(first..)?, 0, 1).is_some()).then_some(name + 4 + u64::from(map))
}

/// Whether all texts of a record lie inside it. Whoever parses it takes as much memory as they say they need.
pub(super) fn is_whole(opcode: u8, body: &[u8]) -> bool {
    match opcode {
        op::METADATA => pairs_after(body, 0, 1),
        op::CHANNEL => pairs_after(body, 4, 2),
        op::SCHEMA => data_after(body, 2, 2),
        _ => true,
    }
}

/// Whether so many strings, and bytes of any kind behind them, lie inside.
fn data_after(body: &[u8], skip: usize, texts: usize) -> bool {
    let data = || {
        let before = usize::try_from(strings(body, skip, texts)?).ok()?;
        let mut rest = Bytes(body.get(before..)?);
        let length = usize::try_from(rest.u32()?).ok()?;
        rest.take(length)
    };
    data().is_some()
}

/// Whether so many strings, and a map of strings behind them, lie inside.
fn pairs_after(body: &[u8], skip: usize, texts: usize) -> bool {
    let map = || {
        let before = usize::try_from(strings(body, skip, texts)?).ok()?;
        let mut rest = Bytes(body.get(before..)?);
        let length = usize::try_from(rest.u32()?).ok()?;
        let mut map = Bytes(rest.take(length)?);
        while !map.0.is_empty() {
            map.string()?;
            map.string()?;
        }
        Some(())
    };
    map().is_some()
}

/// The first place from `from` on where a record of a data section can begin whose bytes are all there.
pub(super) fn search<R: Read + Seek>(file: &mut R, from: u64, size: u64) -> std::io::Result<Option<u64>> {
    let overlap = LOOK + usize::try_from(HEAD).unwrap_or(0);
    let mut start = from;
    let mut window = Vec::new();
    while start + HEAD <= size {
        file.seek(SeekFrom::Start(start))?;
        window.clear();
        file.by_ref().take((WINDOW + overlap) as u64).read_to_end(&mut window)?;
        for at in 0..window.len().min(WINDOW) {
            let Some((opcode, len)) = head(&window[at..]) else { break };
            let (place, body) = (start + at as u64, &window[at + 9..]);
            let whole = (place + HEAD).checked_add(len).is_some_and(|end| end <= size);
            let body = &body[..body.len().min(LOOK).min(usize::try_from(len).unwrap_or(LOOK))];
            // A header stands only at the beginning; an index only behind its chunk, and is not missed.
            let sought = [op::CHUNK, op::ATTACHMENT, op::METADATA, op::DATA_END].contains(&opcode);
            if sought && whole && fits(opcode, len, body) {
                return Ok(Some(place));
            }
        }
        start += WINDOW as u64;
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
        [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
    }

    #[test]
    fn a_record_is_found_amid_other_bytes_and_only_whole() {
        let body = [&[0u8; 28][..], &4u32.to_le_bytes(), b"zstd", &3u64.to_le_bytes(), b"abc"].concat();
        let chunk = record(op::CHUNK, &body);
        for before in [0, 1, WINDOW - 5, WINDOW, 2 * WINDOW + 1] {
            let bytes = [vec![6u8; before], chunk.clone(), vec![6u8; 20]].concat();
            let size = bytes.len() as u64;
            let mut file = std::io::Cursor::new(bytes);
            assert_eq!(search(&mut file, 0, size).unwrap(), Some(before as u64));
            assert_eq!(search(&mut file, before as u64 + 1, size).unwrap(), None);
            assert_eq!(search(&mut file, 0, before as u64 + chunk.len() as u64 - 1).unwrap(), None);
        }
    }

    #[test]
    fn texts_that_reach_beyond_their_record_are_seen_before_memory_is_taken() {
        let text = |length: u32| [&length.to_le_bytes()[..], b"ab"].concat();
        let metadata = |length: u32| [text(2), 12u32.to_le_bytes().to_vec(), text(2), text(length)].concat();
        assert!(is_whole(op::METADATA, &metadata(2)) && !is_whole(op::METADATA, &metadata(3_003_121_673)));
        assert!(mcap::parse_record(op::METADATA, &metadata(2)).is_ok());
        // The schemas of viewers are no texts.
        let data = |length: u32| [&length.to_le_bytes()[..], &[0xff, 0xfe]].concat();
        let schema = |length: u32| [vec![1, 0], text(2), text(2), data(length)].concat();
        assert!(is_whole(op::SCHEMA, &schema(2)) && !is_whole(op::SCHEMA, &schema(3)));
        let channel = |length: u32| [vec![1, 0, 1, 0], text(2), text(length), vec![0; 4]].concat();
        assert!(is_whole(op::CHANNEL, &channel(2)) && !is_whole(op::CHANNEL, &channel(u32::MAX)));
    }

    #[test]
    fn a_length_that_is_not_stated_twice_does_not_pass() {
        let metadata = [&2u32.to_le_bytes()[..], b"ab", &0u32.to_le_bytes()].concat();
        assert!(fits(op::METADATA, 10, &metadata));
        assert!(!fits(op::METADATA, 11, &metadata) && !fits(op::METADATA, 10, &metadata[..5]));
        assert!(fits(op::MESSAGE_INDEX, 6, &[1, 0, 0, 0, 0, 0]) && !fits(op::MESSAGE_INDEX, 6, &[1, 0, 1, 0, 0, 0]));
        assert!(fits(op::DATA_END, 4, &[0; 4]) && !fits(op::MESSAGE, 4, &[0; 4]) && !fits(0x80, 4, &[0; 4]));
    }
}

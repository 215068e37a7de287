//! The bytes of a checkpoint file: header, table of sections, sections. Nothing in it is without a hash, so damage anywhere is noticed.

use std::io::{self, Write};
use std::ops::Range;

/// Version of the layout.
pub const VERSION: u32 = 1;

const MAGIC: [u8; 8] = *b"\x89SQCK\r\n\x1a";
/// Magic, version, number of sections, length of the file; the hash of these and of the table follows.
const HEAD: usize = 24;
const HASH: usize = 32;
const NAME: usize = 24;
/// Name, length and hash of a section.
const ENTRY: usize = NAME + 8 + HASH;
/// No checkpoint needs more sections; a damaged count is refused before anything is made of it.
const MOST: usize = 256;

/// Why a file is no checkpoint that could be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// Another kind of file.
    #[error("it does not begin as a checkpoint does")]
    Magic,
    /// Written in another layout.
    #[error("it has version {0} of the layout, but this program reads version {VERSION}")]
    Version(u32),
    /// Cut off, or something was added.
    #[error("it should have {expected} bytes, but has {found}")]
    Length {
        /// What its header says, or what a header needs.
        expected: u64,
        /// What there is.
        found: u64,
    },
    /// Header or table of sections.
    #[error("its header is damaged")]
    Header,
    /// A section's hash does not match.
    #[error("its section `{0}` is damaged")]
    Section(String),
    /// A section that every checkpoint has.
    #[error("it has no section `{0}`")]
    Absent(String),
    /// The bytes are as they were written, but this program cannot make sense of them.
    #[error("its section `{section}` cannot be used: {reason}")]
    Content {
        /// Section.
        section: String,
        /// Why.
        reason: String,
    },
}

/// The sections of a file whose hashes all match.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sections {
    bytes: Vec<u8>,
    table: Vec<(String, Range<usize>)>,
}

impl Sections {
    /// One section.
    ///
    /// # Errors
    /// If there is none of this name.
    pub fn get(&self, name: &str) -> Result<&[u8], Damage> {
        let found = self.iter().find(|(n, _)| *n == name);
        found.map(|(_, bytes)| bytes).ok_or_else(|| Damage::Absent(name.to_owned()))
    }

    /// Names and contents in their order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.table.iter().map(|(name, range)| (name.as_str(), &self.bytes[range.clone()]))
    }
}

/// Writes a file of these sections.
///
/// # Errors
/// If it cannot be written, or a name has more than 24 bytes.
pub fn encode(sections: &[(String, &[u8])], out: &mut dyn Write) -> io::Result<()> {
    let mut head = Vec::with_capacity(HEAD + ENTRY * sections.len());
    let contents: usize = sections.iter().map(|(_, bytes)| bytes.len()).sum();
    let length = HEAD + HASH + ENTRY * sections.len() + contents;
    head.extend(MAGIC);
    head.extend(VERSION.to_le_bytes());
    head.extend(u32::try_from(sections.len()).map_err(io::Error::other)?.to_le_bytes());
    head.extend((length as u64).to_le_bytes());
    for (name, bytes) in sections {
        let mut padded = [0; NAME];
        let place = padded.get_mut(..name.len()).ok_or_else(|| io::Error::other(format!("`{name}` is too long")))?;
        place.copy_from_slice(name.as_bytes());
        head.extend(padded);
        head.extend((bytes.len() as u64).to_le_bytes());
        head.extend(blake3::hash(bytes).as_bytes());
    }
    out.write_all(&head[..HEAD])?;
    out.write_all(blake3::hash(&head).as_bytes())?;
    out.write_all(&head[HEAD..])?;
    sections.iter().try_for_each(|(_, bytes)| out.write_all(bytes))
}

/// Reads what [`encode`] wrote.
///
/// # Errors
/// If any byte is not as it was written.
pub fn decode(bytes: Vec<u8>) -> Result<Sections, Damage> {
    let found = bytes.len() as u64;
    let short = |expected: usize| Damage::Length { expected: expected as u64, found };
    let part = |range: Range<usize>| bytes.get(range.clone()).ok_or_else(|| short(range.end));
    let number = |at: usize| Ok(u64::from_le_bytes(part(at..at + 8)?.try_into().expect("eight bytes")));
    if part(0..MAGIC.len())? != MAGIC {
        return Err(Damage::Magic);
    }
    let word = number(8)?;
    let (version, count) = (word as u32, (word >> 32) as usize);
    if version != VERSION {
        return Err(Damage::Version(version));
    }
    let expected = number(16)?;
    if expected != found {
        return Err(Damage::Length { expected, found });
    }
    if count > MOST {
        return Err(Damage::Header);
    }
    let first = HEAD + HASH + ENTRY * count;
    let mut hasher = blake3::Hasher::new();
    hasher.update(part(0..HEAD)?).update(part(HEAD + HASH..first)?);
    if part(HEAD..HEAD + HASH)? != hasher.finalize().as_bytes() {
        return Err(Damage::Header);
    }
    let (mut table, mut at) = (Vec::with_capacity(count), first);
    for entry in (HEAD + HASH..first).step_by(ENTRY) {
        let name = String::from_utf8_lossy(part(entry..entry + NAME)?).trim_end_matches('\0').to_owned();
        let length = usize::try_from(number(entry + NAME)?).map_err(|_| Damage::Header)?;
        let end = at.checked_add(length).ok_or(Damage::Header)?;
        if part(entry + NAME + 8..entry + ENTRY)? != blake3::hash(part(at..end)?).as_bytes() {
            return Err(Damage::Section(name));
        }
        table.push((name, at..end));
        at = end;
    }
    if at as u64 != found {
        return Err(Damage::Header);
    }
    Ok(Sections { bytes, table })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Vec<u8> {
        let mut bytes = Vec::new();
        let sections =
            [("run".to_owned(), &b"{}"[..]), ("empty".to_owned(), &[]), ("state/positions".to_owned(), &[7; 40])];
        encode(&sections, &mut bytes).expect("a vector takes everything");
        bytes
    }

    #[test]
    fn it_reads_back() {
        let sections = decode(small()).expect("undamaged");
        let names: Vec<(&str, usize)> = sections.iter().map(|(n, b)| (n, b.len())).collect();
        assert_eq!(names, [("run", 2), ("empty", 0), ("state/positions", 40)]);
        assert_eq!(sections.get("run"), Ok(&b"{}"[..]));
        assert_eq!(sections.get("walk"), Err(Damage::Absent("walk".into())));
    }

    #[test]
    fn every_truncation_and_every_flipped_bit_is_noticed() {
        let bytes = small();
        for length in 0..bytes.len() {
            assert!(decode(bytes[..length].to_vec()).is_err(), "cut to {length}");
        }
        assert!(decode([&bytes[..], &[0]].concat()).is_err(), "a byte more");
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(decode(damaged).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn damage_has_its_name() {
        let changed = |at: usize, to: u8| {
            let mut bytes = small();
            bytes[at] = to;
            decode(bytes).expect_err("damaged")
        };
        assert_eq!(changed(0, 0), Damage::Magic);
        assert_eq!(changed(8, 9), Damage::Version(9));
        assert_eq!(changed(12, 200), Damage::Length { expected: 24 + 32 + 200 * 64, found: 290 });
        assert_eq!(changed(56, 0), Damage::Header);
        let last = small().len() - 1;
        assert_eq!(changed(last, 0), Damage::Section("state/positions".into()));
        assert_eq!(decode(Vec::new()), Err(Damage::Length { expected: 8, found: 0 }));
    }

    #[test]
    fn a_name_that_does_not_fit_is_refused() {
        assert!(encode(&[("x".repeat(25), &[])], &mut Vec::new()).is_err());
    }
}

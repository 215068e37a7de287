//! One file from beginning to end, record by record: whole chunks are given, damage is named and skipped.
//!
//! An index would be faster to seek in, but reading by index checks no checksum and does not work for a run that was killed.

use super::RecordingError;
use super::shape::{Bytes, HEAD, fits, head, is_whole, search};
use super::summary::{Summary, record, summary};
use mcap::Attachment;
use mcap::records::{Channel, MessageHeader, Metadata, Record, Statistics, op};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Enough of a record's beginning to see whether its length can be right.
const LOOK: u64 = 512;

/// A schema: name, encoding, text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schema {
    /// Name.
    pub name: String,
    /// How the text is written.
    pub encoding: String,
    /// The text.
    pub data: Vec<u8>,
}

/// Channels and schemas that a file has declared.
#[derive(Debug, Clone, Default)]
pub struct Channels {
    /// Schemas by number.
    pub schemas: BTreeMap<u16, Schema>,
    /// Channels by number.
    pub channels: BTreeMap<u16, Channel>,
}

impl Channels {
    /// The topic of a channel.
    #[must_use]
    pub fn topic(&self, id: u16) -> Option<&str> {
        self.channels.get(&id).map(|c| c.topic.as_str())
    }

    pub(super) fn learn(&mut self, record: &Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let (name, encoding) = (header.name.clone(), header.encoding.clone());
                self.schemas.insert(header.id, Schema { name, encoding, data: data.to_vec() });
            }
            Record::Channel(channel) => {
                self.channels.insert(channel.id, channel.clone());
            }
            _ => {}
        }
    }
}

/// A chunk whose checksum is right.
#[derive(Debug, Clone)]
pub struct Chunk {
    /// Where it begins.
    pub at: u64,
    /// Its length in the file.
    pub length: u64,
    /// First and last time that its head states, in ns; no checksum protects them.
    pub times: (u64, u64),
    /// Its records.
    records: Vec<u8>,
}

impl Chunk {
    /// Bytes before compression.
    #[must_use]
    pub fn uncompressed(&self) -> u64 {
        self.records.len() as u64
    }

    /// Its messages in order.
    pub fn messages(&self) -> impl Iterator<Item = (MessageHeader, &[u8])> {
        let mut rest = Bytes(&self.records);
        std::iter::from_fn(move || record(&mut rest)).filter_map(|(opcode, body)| {
            let message = (opcode == op::MESSAGE).then(|| mcap::parse_record(opcode, body));
            match message {
                Some(Ok(Record::Message { header, data })) => Some((header, &body[body.len() - data.len()..])),
                _ => None,
            }
        })
    }
}

/// What stands at one place of a file.
#[derive(Debug)]
pub enum Part {
    /// Messages; the checksum is right.
    Chunk(Chunk),
    /// A file inside the file; the checksum is right.
    Attachment(Attachment<'static>),
    /// Named texts, which no checksum of their own protects.
    Metadata(Metadata),
    /// Bytes that were skipped, up to the next record that is whole.
    Damaged {
        /// Where they begin.
        at: u64,
        /// What is wrong.
        what: String,
        /// Whether messages may have been lost there.
        messages: bool,
    },
    /// The file ends in the middle of a record, or before its own end: the run was killed or is still going.
    Cut {
        /// Where what is whole ends.
        at: u64,
        /// Whether a message stood there that is not whole.
        messages: bool,
    },
    /// The end of the data; `flaw` says what is wrong outside of chunks and attachments, though those are whole.
    End {
        /// What is wrong, if anything.
        flaw: Option<String>,
    },
}

/// A file being read.
pub struct Scan {
    path: PathBuf,
    file: BufReader<File>,
    size: u64,
    at: u64,
    /// Of all bytes before `at`, as long as none was skipped.
    crc: Option<crc32fast::Hasher>,
    channels: Channels,
    summary: Summary,
    ended: bool,
}

impl Scan {
    /// Opens a file and looks at its beginning and end.
    ///
    /// # Errors
    /// If it cannot be read, or is not MCAP.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let io = RecordingError::io(path);
        let file = File::open(path).map_err(&io)?;
        let size = file.metadata().map_err(&io)?.len();
        let mut file = BufReader::with_capacity(1 << 16, file);
        let mut magic = Vec::new();
        file.by_ref().take(8).read_to_end(&mut magic).map_err(&io)?;
        // A file that was just begun may be shorter.
        if !mcap::MAGIC.starts_with(&magic) {
            return Err(RecordingError::NoRecording(path.into()));
        }
        let summary = summary(&mut file, size).map_err(&io)?;
        let mut crc = crc32fast::Hasher::new();
        crc.update(&magic);
        let channels = summary.channels.clone();
        let at = magic.len() as u64;
        Ok(Self { path: path.into(), file, size, at, crc: Some(crc), channels, summary, ended: false })
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its length when it was opened.
    #[must_use]
    pub fn size(&self) -> u64 {
        self.size
    }

    /// What is known of channels so far.
    #[must_use]
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    /// What a complete file says it holds.
    #[must_use]
    pub fn statistics(&self) -> Option<&Statistics> {
        self.summary.statistics.as_ref()
    }

    /// The next part; `None` behind [`Part::Cut`] and [`Part::End`].
    ///
    /// # Errors
    /// If the system cannot read the file.
    pub fn next_part(&mut self) -> Result<Option<Part>, RecordingError> {
        while !self.ended {
            let part = self.step().map_err(|e| RecordingError::Io { path: self.path.clone(), source: e })?;
            if part.is_some() {
                self.ended |= matches!(part, Some(Part::Cut { .. } | Part::End { .. }));
                return Ok(part);
            }
        }
        Ok(None)
    }

    /// Takes one record; `None` for one that says nothing.
    fn step(&mut self) -> std::io::Result<Option<Part>> {
        let at = self.at;
        self.file.seek(SeekFrom::Start(at))?;
        let mut bytes = self.read(HEAD.min(self.size.saturating_sub(at)), Vec::new())?;
        let Some((opcode, len)) = head(&bytes) else { return self.astray("the file ends", bytes.first()).map(Some) };
        if len > self.size - at - HEAD {
            return self.astray("a record is longer than the file", Some(&opcode)).map(Some);
        }
        bytes = self.read(len.min(LOOK), bytes)?;
        if !fits(opcode, len, &bytes[9..]) {
            return self.astray("no record is like this", Some(&opcode)).map(Some);
        }
        bytes = self.read(len.saturating_sub(LOOK), bytes)?;
        let body = &bytes[9..];
        if body.len() as u64 != len {
            return self.astray("the file ends", Some(&opcode)).map(Some);
        }
        let found = match opcode {
            op::CHUNK => chunk(at, body, &mut self.channels).map(|chunk| Some(Part::Chunk(chunk))),
            op::ATTACHMENT => attachment(body).map(|attachment| Some(Part::Attachment(attachment))),
            op::METADATA => metadata(body).map(|metadata| Some(Part::Metadata(metadata))),
            op::DATA_END => return Ok(Some(self.end(body))),
            _ => Ok(None),
        };
        match found {
            Ok(part) => {
                self.at += HEAD + len;
                if let Some(crc) = &mut self.crc {
                    crc.update(&bytes);
                }
                Ok(part)
            }
            Err(what) => {
                let skipped = self.astray(&what, Some(&opcode))?;
                let spared = matches!(opcode, op::ATTACHMENT | op::METADATA);
                Ok(Some(match skipped {
                    Part::Damaged { at, what, .. } if spared => Part::Damaged { at, what, messages: false },
                    skipped => skipped,
                }))
            }
        }
    }

    /// Appends up to `n` bytes of the file.
    fn read(&mut self, n: u64, mut bytes: Vec<u8>) -> std::io::Result<Vec<u8>> {
        self.file.by_ref().take(n).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// Nothing can be made of the record here: goes on behind it at the next one, if there is any.
    fn astray(&mut self, what: &str, opcode: Option<&u8>) -> std::io::Result<Part> {
        let at = self.at;
        self.crc = None;
        let damaged = Part::Damaged { at, what: what.into(), messages: true };
        match search(&mut self.file, at + 1, self.size)? {
            Some(next) => self.at = next,
            // The end of the data is damaged, but the file's end is there.
            None if self.summary.finished => self.at = self.size,
            None => {
                let messages = opcode.is_some_and(|o| ![op::MESSAGE_INDEX, op::DATA_END].contains(o));
                return Ok(Part::Cut { at, messages });
            }
        }
        if self.at == self.size {
            self.ended = true;
        }
        Ok(damaged)
    }

    /// What follows the data must be there, and everything must match.
    fn end(&mut self, body: &[u8]) -> Part {
        let stored = Bytes(body).u32().unwrap_or(0);
        if !self.summary.finished {
            return Part::Cut { at: self.at, messages: false };
        }
        let computed = self.crc.take().map(crc32fast::Hasher::finalize);
        let flaw = if !self.summary.intact {
            Some("the index at the end does not match its checksum".to_owned())
        } else if computed.is_some_and(|computed| computed != stored) {
            Some("something between the chunks does not match the checksum of the data".to_owned())
        } else {
            None
        };
        Part::End { flaw }
    }
}

/// The chunk in a record's body, or what is wrong with it. Its channels are learned.
fn chunk(at: u64, body: &[u8], channels: &mut Channels) -> Result<Chunk, String> {
    let Ok(Record::Chunk { header, data }) = mcap::parse_record(op::CHUNK, body) else {
        return Err("a chunk's head cannot be read".into());
    };
    let size = header.uncompressed_size;
    let mut records = Vec::new();
    match header.compression.as_str() {
        "" => records = data.into_owned(),
        "zstd" => {
            // One byte more than announced shows that there is more; no length in the file decides how much memory is taken.
            let decoder = zstd::stream::read::Decoder::new(&data[..]);
            let read = decoder.and_then(|d| d.take(size.saturating_add(1)).read_to_end(&mut records));
            read.map_err(|e| format!("a chunk cannot be decompressed: {e}"))?;
        }
        other => return Err(format!("a chunk is compressed with `{other}`, which this program does not read")),
    }
    // 0 would mean that there is no checksum, and what is not protected is not believed.
    let (stored, computed) = (header.uncompressed_crc, crc32fast::hash(&records));
    if records.len() as u64 != size || stored != computed {
        return Err(format!("a chunk's checksum is {computed:08x} instead of {stored:08x}"));
    }
    let mut rest = Bytes(&records);
    while let Some((opcode, body)) = record(&mut rest) {
        if !is_whole(opcode, body) {
            return Err("a chunk was written wrongly: a text is longer than its record".into());
        }
        let parsed = mcap::parse_record(opcode, body).map_err(|e| format!("a chunk was written wrongly: {e}"))?;
        channels.learn(&parsed);
    }
    if !rest.0.is_empty() {
        return Err("a chunk was written wrongly: its last record is not whole".into());
    }
    let times = (header.message_start_time, header.message_end_time);
    Ok(Chunk { at, length: HEAD + body.len() as u64, times, records })
}

fn attachment(body: &[u8]) -> Result<Attachment<'static>, String> {
    match mcap::parse_record(op::ATTACHMENT, body) {
        Ok(Record::Attachment { header, data, crc }) if crc != 0 => Ok(Attachment {
            log_time: header.log_time,
            create_time: header.create_time,
            name: header.name,
            media_type: header.media_type,
            data: data.into_owned().into(),
        }),
        _ => Err("an attachment does not match its checksum".into()),
    }
}

fn metadata(body: &[u8]) -> Result<Metadata, String> {
    let unreadable = || "a metadata record cannot be read".to_owned();
    if !is_whole(op::METADATA, body) {
        return Err(unreadable());
    }
    match mcap::parse_record(op::METADATA, body) {
        Ok(Record::Metadata(metadata)) => Ok(metadata),
        _ => Err(unreadable()),
    }
}

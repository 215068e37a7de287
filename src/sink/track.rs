//! One MCAP file: channels by topic, a chunk per snapshot, and an end that is always written.

use super::SinkError;
use crate::recording::FORMAT;
use foxglove::Encode;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

/// A recording being written to `W`.
pub(super) struct Track<W: Write + Seek> {
    path: PathBuf,
    writer: Writer<W>,
    channels: BTreeMap<&'static str, u16>,
    messages: u64,
    /// Messages at the end of the last chunk.
    flushed: u64,
    chunks: u64,
    failed: bool,
}

/// How recordings are written. Without seeking a chunk is written whole or not at all, which keeps the end of a killed run clean.
pub(super) fn options(threads: u32) -> WriteOptions {
    WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .compression_level(1)
        .compression_threads(threads)
        .disable_seeking(true)
        .profile("")
        .library(concat!("squirm ", env!("CARGO_PKG_VERSION")))
}

/// Time of a message: when in the simulation, and its count.
#[derive(Debug, Clone, Copy)]
pub(super) struct When {
    pub nanoseconds: u64,
    pub sequence: u32,
}

impl<W: Write + Seek> Track<W> {
    /// Begins a recording.
    pub fn new(path: &Path, sink: W, threads: u32) -> Result<Self, SinkError> {
        let writer = options(threads).create(sink).map_err(|e| SinkError::mcap(path, e))?;
        Ok(Self {
            path: path.into(),
            writer,
            channels: BTreeMap::new(),
            messages: 0,
            flushed: 0,
            chunks: 0,
            failed: false,
        })
    }

    /// Attaches a named text.
    pub fn attach(&mut self, name: &str, media_type: &str, text: &str) -> Result<(), SinkError> {
        let data = text.as_bytes().into();
        let attachment =
            Attachment { log_time: 0, create_time: 0, name: name.into(), media_type: media_type.into(), data };
        self.checked(|w| w.attach(&attachment))
    }

    /// Writes a metadata record.
    pub fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), SinkError> {
        let record = Metadata { name: name.into(), metadata };
        self.checked(|w| w.write_metadata(&record))
    }

    /// Appends one of our own messages.
    pub fn snapshot(&mut self, topic: &'static str, bytes: &[u8], when: When) -> Result<(), SinkError> {
        let channel =
            self.channel(topic, "squirm", || ("squirm.Snapshot".into(), "squirm".into(), FORMAT.as_bytes().into()))?;
        self.message(channel, bytes, when)
    }

    /// Appends a message for viewers.
    pub fn view<M: Encode>(&mut self, topic: &'static str, message: &M, when: When) -> Result<(), SinkError> {
        let channel = self.channel(topic, &M::get_message_encoding(), || {
            M::get_schema().map_or_else(Default::default, |s| (s.name, s.encoding, s.data))
        })?;
        let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or(0));
        message
            .encode(&mut bytes)
            .map_err(|e| SinkError::Io { path: self.path.clone(), source: std::io::Error::other(e.to_string()) })?;
        self.message(channel, &bytes, when)
    }

    /// Ends the chunk and hands it to the system.
    pub fn flush(&mut self) -> Result<(), SinkError> {
        self.checked(Writer::flush)?;
        self.chunks += u64::from(self.messages > self.flushed);
        self.flushed = self.messages;
        Ok(())
    }

    /// Chunks so far: the index at the end lists each, and is kept in memory until then.
    pub fn chunks(&self) -> u64 {
        self.chunks
    }

    /// Writes the summary and the end; returns how many messages there are. The sink's own buffer is its owner's to flush.
    pub fn finish(&mut self) -> Result<u64, SinkError> {
        self.checked(|w| w.finish().map(drop))?;
        Ok(self.messages)
    }

    /// Messages so far.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// The path, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the sink back.
    pub fn into_inner(self) -> W {
        self.writer.into_inner()
    }

    fn channel(
        &mut self,
        topic: &'static str,
        encoding: &str,
        schema: impl FnOnce() -> (String, String, std::borrow::Cow<'static, [u8]>),
    ) -> Result<u16, SinkError> {
        if let Some(id) = self.channels.get(topic) {
            return Ok(*id);
        }
        let (name, schema_encoding, data) = schema();
        let id = self.checked(|w| {
            let schema = w.add_schema(&name, &schema_encoding, &data)?;
            w.add_channel(schema, topic, encoding, &BTreeMap::new())
        })?;
        self.channels.insert(topic, id);
        Ok(id)
    }

    fn message(&mut self, channel_id: u16, bytes: &[u8], when: When) -> Result<(), SinkError> {
        let (log_time, publish_time) = (when.nanoseconds, when.nanoseconds);
        let header = MessageHeader { channel_id, sequence: when.sequence, log_time, publish_time };
        self.checked(|w| w.write_to_known_channel(&header, bytes))?;
        self.messages += 1;
        Ok(())
    }

    /// After one failure the file's end is undefined, and the writer must not be asked again.
    fn checked<T>(&mut self, action: impl FnOnce(&mut Writer<W>) -> mcap::McapResult<T>) -> Result<T, SinkError> {
        if self.failed {
            let source = mcap::McapError::AttemptedWriteAfterFailure;
            return Err(SinkError::Mcap { path: self.path.clone(), source });
        }
        action(&mut self.writer).map_err(|e| {
            self.failed = true;
            SinkError::mcap(&self.path, e)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Scalars;
    use std::io::{Cursor, Error, ErrorKind, Result as IoResult, SeekFrom};

    /// A disk with room for so many bytes.
    struct Disk {
        file: Cursor<Vec<u8>>,
        room: usize,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
            let taken = bytes.len().min(self.room.saturating_sub(self.file.get_ref().len()));
            if taken == 0 && !bytes.is_empty() {
                return Err(Error::from(ErrorKind::StorageFull));
            }
            self.file.write(&bytes[..taken])
        }
        fn flush(&mut self) -> IoResult<()> {
            Ok(())
        }
    }

    impl Seek for Disk {
        fn seek(&mut self, to: SeekFrom) -> IoResult<u64> {
            self.file.seek(to)
        }
    }

    #[test]
    fn a_full_disk_is_named_and_what_was_written_before_reads() {
        let path = Path::new("run.mcap");
        let message = Scalars::default().encode(&crate::wire::Stamp::default());
        let mut most = 0;
        for room in (4..40_000).step_by(997) {
            let disk = Disk { file: Cursor::new(Vec::new()), room };
            let Ok(mut track) = Track::new(path, disk, 0) else {
                assert_eq!(room, 4);
                continue;
            };
            let mut written = 0usize;
            let failure = loop {
                let when = When { nanoseconds: 0, sequence: 0 };
                match track.snapshot("/squirm/scalars", &message, when).and_then(|()| track.flush()) {
                    Ok(()) => written += 1,
                    Err(e) => break e,
                }
            };
            assert!(matches!(failure, SinkError::DiskFull(p) if p == path), "room {room}");
            assert!(track.snapshot("/squirm/scalars", &message, When { nanoseconds: 0, sequence: 0 }).is_err());
            assert!(track.finish().is_err());
            let bytes = track.into_inner().file.into_inner();
            let whole = mcap::MessageStream::new(&bytes).unwrap().take_while(Result::is_ok).count();
            // Where the disk fills up behind a whole chunk, its message is there although writing it was refused.
            assert!(whole == written || whole == written + 1, "room {room}: {whole} of {written}");
            most = most.max(written);
        }
        assert!(most > 10, "{most}");
    }
}

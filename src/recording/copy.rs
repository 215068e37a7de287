//! A new recording made from others: the same messages, attachments and metadata, complete and indexed.

use super::scan::{Channels, Schema};
use super::{FORMAT, RecordingError, TOPICS};
use crate::wire::Kind;
use mcap::records::{Channel, MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A file being written. Unless [`Copy::finish`] succeeds, it is removed again.
pub(super) struct Copy {
    path: PathBuf,
    writer: Option<Writer<BufWriter<File>>>,
    topics: BTreeMap<String, u16>,
    attached: Vec<(String, Vec<u8>)>,
    described: Vec<Metadata>,
    /// Messages written.
    pub messages: u64,
    open: bool,
}

impl Copy {
    /// Begins a file that must not exist.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let file = File::create_new(path).map_err(RecordingError::io(path))?;
        let options = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .disable_seeking(true)
            .profile("")
            .library(concat!("squirm ", env!("CARGO_PKG_VERSION")));
        let writer = options.create(BufWriter::with_capacity(1 << 16, file));
        let source = |source| RecordingError::Write { path: path.into(), source };
        let (attached, described) = (Vec::new(), Vec::new());
        let writer = Some(writer.map_err(source)?);
        Ok(Self { path: path.into(), writer, topics: BTreeMap::new(), attached, described, messages: 0, open: false })
    }

    fn write<T>(
        &mut self,
        action: impl FnOnce(&mut Writer<BufWriter<File>>) -> mcap::McapResult<T>,
    ) -> Result<T, RecordingError> {
        let source = |source| RecordingError::Write { path: self.path.clone(), source };
        let writer = self.writer.as_mut().ok_or(mcap::McapError::AttemptedWriteAfterFailure).map_err(source)?;
        action(writer).map_err(source)
    }

    /// Adds an attachment once; another one of the same name gets a number.
    pub fn attach(&mut self, attachment: Attachment<'static>) -> Result<(), RecordingError> {
        let entry = (attachment.name.clone(), attachment.data.to_vec());
        if self.attached.contains(&entry) {
            return Ok(());
        }
        let same = self.attached.iter().filter(|(name, _)| *name == entry.0).count();
        let name = match entry.0.rsplit_once('.') {
            _ if same == 0 => entry.0.clone(),
            Some((stem, ending)) => format!("{stem}.{same:04}.{ending}"),
            None => format!("{}.{same:04}", entry.0),
        };
        self.attached.push(entry);
        self.end_chunk()?;
        self.write(|w| w.attach(&Attachment { name, ..attachment }))
    }

    /// Adds a metadata record once.
    pub fn describe(&mut self, metadata: &Metadata) -> Result<(), RecordingError> {
        if self.described.contains(metadata) {
            return Ok(());
        }
        self.described.push(metadata.clone());
        self.end_chunk()?;
        self.write(|w| w.write_metadata(metadata))
    }

    /// Appends a message on a channel of the file it comes from.
    pub fn message(
        &mut self,
        header: MessageHeader,
        bytes: &[u8],
        channels: &Channels,
        channel: &Channel,
    ) -> Result<(), RecordingError> {
        let channel_id = match self.topics.get(&channel.topic) {
            Some(id) => *id,
            None => self.channel(channel, channels.schemas.get(&channel.schema_id))?,
        };
        self.open = true;
        self.messages += 1;
        self.write(|w| w.write_to_known_channel(&MessageHeader { channel_id, ..header }, bytes))
    }

    fn channel(&mut self, channel: &Channel, schema: Option<&Schema>) -> Result<u16, RecordingError> {
        let id = self.write(|w| {
            let schema = match schema {
                Some(schema) => w.add_schema(&schema.name, &schema.encoding, &schema.data)?,
                None => 0,
            };
            w.add_channel(schema, &channel.topic, &channel.message_encoding, &channel.metadata)
        })?;
        self.topics.insert(channel.topic.clone(), id);
        Ok(id)
    }

    /// Ends the chunk, so that chunks stay as they were.
    pub fn end_chunk(&mut self) -> Result<(), RecordingError> {
        if std::mem::take(&mut self.open) { self.write(Writer::flush) } else { Ok(()) }
    }

    /// Writes index and end, and waits until the file is on the disk.
    pub fn finish(mut self) -> Result<u64, RecordingError> {
        self.end_chunk()?;
        self.write(|w| w.finish().map(drop))?;
        let io = RecordingError::io(&self.path);
        if let Some(writer) = self.writer.take() {
            let file = writer.into_inner().into_inner().map_err(|e| io(e.into_error()));
            if let Err(error) = file.and_then(|file| file.sync_all().map_err(&io)) {
                // What cannot be flushed is no complete file.
                let _ = std::fs::remove_file(&self.path);
                return Err(error);
            }
        }
        Ok(self.messages)
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        if self.writer.take().is_some() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// A channel of squirm's own for messages whose channel was lost.
pub(super) fn own_channel(kind: Kind) -> (Channels, Channel) {
    let mut channels = Channels::default();
    let data = FORMAT.as_bytes().to_vec();
    channels.schemas.insert(1, Schema { name: "squirm.Snapshot".into(), encoding: "squirm".into(), data });
    let topic = format!("{TOPICS}{}", kind.topic());
    let channel = Channel { id: 0, schema_id: 1, topic, message_encoding: "squirm".into(), metadata: BTreeMap::new() };
    (channels, channel)
}

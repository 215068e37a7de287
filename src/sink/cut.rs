//! Cutting a recording to its first messages, as a complete file with its indexes: what a resumed run does with what goes beyond
//! its checkpoint.

use super::SinkError;
use super::track::options;
use mcap::records::{self, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult, Writer};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Longest record that is believed; a damaged length would otherwise ask for any amount of memory.
const LONGEST: usize = 1 << 33;
/// Bytes after the summary: the footer record and the end's magic.
const END: u64 = 1 + 8 + 20 + 8;

/// Leaves in the recording at `path` exactly its first `wanted` messages. A complete recording of as many is left as it is; any
/// other is written anew beside it and takes its place.
///
/// # Errors
/// If there are fewer messages, something before their end is damaged, or the new file cannot be written.
pub(super) fn cut(path: &Path, wanted: u64) -> Result<(), SinkError> {
    let io = |e| SinkError::io(path, e);
    if messages_of_complete(path).map_err(io)? == Some(wanted) {
        return Ok(());
    }
    let temporary = path.with_extension("mcap.tmp");
    let failed = |e| SinkError::mcap(&temporary, e);
    let file = File::create(&temporary).map_err(|e| SinkError::io(&temporary, e))?;
    let handle = file.try_clone().map_err(|e| SinkError::io(&temporary, e))?;
    let mut copy = Copy {
        writer: options(1).create(BufWriter::with_capacity(1 << 16, file)).map_err(failed)?,
        schemas: HashMap::from([(0, 0)]),
        channels: HashMap::new(),
        messages: 0,
    };
    let ended = copy.take(path, wanted);
    if copy.messages < wanted {
        let source = ended.err();
        let _ = std::fs::remove_file(&temporary);
        return Err(SinkError::Shortened { path: path.into(), found: copy.messages, wanted, source });
    }
    let mut writer = copy.writer;
    writer.finish().map_err(failed)?;
    writer.into_inner().into_inner().map_err(|e| SinkError::io(&temporary, e.into_error()))?;
    handle.sync_all().map_err(|e| SinkError::io(&temporary, e))?;
    std::fs::rename(&temporary, path).map_err(io)
}

/// How many messages a recording has that ends as it should; `None` if it does not.
fn messages_of_complete(path: &Path) -> io::Result<Option<u64>> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let Some(end) = length.checked_sub(END) else { return Ok(None) };
    file.seek(SeekFrom::Start(end))?;
    let mut footer = [0; END as usize];
    file.read_exact(&mut footer)?;
    if footer[0] != op::FOOTER || !footer.ends_with(mcap::MAGIC) {
        return Ok(None);
    }
    let start = u64::from_le_bytes(footer[9..17].try_into().expect("eight bytes"));
    // A summary is small: it has indexes, no messages.
    let size = end.checked_sub(start).filter(|n| start > 0 && *n < 1 << 32).and_then(|n| usize::try_from(n).ok());
    let Some(size) = size else { return Ok(None) };
    file.seek(SeekFrom::Start(start))?;
    let mut summary = vec![0; size];
    file.read_exact(&mut summary)?;
    let mut rest = &summary[..];
    while let Some((head, after)) = rest.split_at_checked(9) {
        let length = u64::from_le_bytes(head[1..].try_into().expect("eight bytes"));
        let Some((record, after)) = usize::try_from(length).ok().and_then(|n| after.split_at_checked(n)) else { break };
        if let (op::STATISTICS, Some(count)) = (head[0], record.get(..8)) {
            return Ok(Some(u64::from_le_bytes(count.try_into().expect("eight bytes"))));
        }
        rest = after;
    }
    Ok(None)
}

/// A recording that is being copied, with the new numbers of its schemas and channels.
struct Copy<W: Write + Seek> {
    writer: Writer<W>,
    schemas: HashMap<u16, u16>,
    channels: HashMap<u16, (u16, bool)>,
    messages: u64,
}

impl<W: Write + Seek> Copy<W> {
    /// Copies records until there are as many messages as wanted.
    fn take(&mut self, path: &Path, wanted: u64) -> McapResult<()> {
        let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
        let options =
            LinearReaderOptions::default().with_prevalidate_chunk_crcs(true).with_record_length_limit(LONGEST);
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(n) => {
                    let n = n.clamp(1, 1 << 20);
                    let read = file.read(reader.insert(n))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode: op::MESSAGE, .. } if self.messages == wanted => return Ok(()),
                // What follows is the summary, which is made anew.
                LinearReadEvent::Record { opcode: op::DATA_END, .. } => return Ok(()),
                LinearReadEvent::Record { data, opcode } => self.record(mcap::parse_record(opcode, data)?)?,
            }
        }
        Ok(())
    }

    fn record(&mut self, record: Record<'_>) -> McapResult<()> {
        match record {
            Record::Schema { header, data } => {
                let id = self.writer.add_schema(&header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, id);
            }
            Record::Channel(channel) => {
                let schema = *self.schemas.get(&channel.schema_id).ok_or(McapError::UnexpectedEof)?;
                let id =
                    self.writer.add_channel(schema, &channel.topic, &channel.message_encoding, &channel.metadata)?;
                // As in the original, each snapshot begins a chunk, and so do the many points for viewers.
                let begins = channel.topic.starts_with("/squirm/") || channel.topic.starts_with("/fluid/");
                self.channels.insert(channel.id, (id, begins));
            }
            Record::Message { header, data } => {
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                let (channel_id, begins) = *self.channels.get(&header.channel_id).ok_or(unknown)?;
                if begins {
                    self.writer.flush()?;
                }
                self.writer.write_to_known_channel(&records::MessageHeader { channel_id, ..header }, &data)?;
                self.messages += 1;
            }
            Record::Attachment { header, data, .. } => self.writer.attach(&mcap::Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data: Cow::Borrowed(&data),
            })?,
            Record::Metadata(metadata) => self.writer.write_metadata(&metadata)?,
            _ => {}
        }
        Ok(())
    }
}

"""One MCAP file: a scan that verifies every checksum and finds the snapshots, and reading them one by one.

The framing is read here and not by the `mcap` package's readers, since those cannot tell a file that ends in the middle
from one that is damaged. The records themselves are parsed by `mcap`.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Footer, McapRecord, Message, Metadata
from mcap.stream_reader import CRCValidationError, breakup_chunk

from .errors import DamagedRecording, NotARecording, NotASnapshot
from .snapshot import TOPICS, Snapshot, read_header

if TYPE_CHECKING:
    from collections.abc import Iterator

MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")
_PREFIX = "/squirm/"
#: Records that stand between the header and the end of the data.
_DATA = {
    Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.ATTACHMENT,
    Opcode.METADATA,
}  # fmt: skip
_SUMMARY = {
    Opcode.SCHEMA, Opcode.CHANNEL, Opcode.STATISTICS, Opcode.CHUNK_INDEX, Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX, Opcode.SUMMARY_OFFSET,
}  # fmt: skip
#: What parsing damaged records may raise.
_WRONG = (McapError, ValueError, struct.error, MemoryError, OverflowError, zstandard.ZstdError)
#: Longest chunk that is believed; a damaged length would otherwise ask for any amount of memory.
_LONGEST = 1 << 33
_HINT = "`squirm recover` keeps what is whole"


class Entry(NamedTuple):
    """Where one snapshot lies, and what its header says."""

    path: Path
    #: First byte of the chunk's record.
    offset: int
    #: Number of the message within its chunk.
    place: int
    step: int
    time: float
    seq: int
    every: int
    run_id: bytes


@dataclass
class Scan:
    """What a file holds."""

    path: Path
    entries: dict[str, list[Entry]] = field(default_factory=lambda: {topic: [] for topic in TOPICS})
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, str] = field(default_factory=dict)
    #: Whether the end is missing.
    truncated: bool = False
    #: Header of the first snapshot.
    box_size: tuple[float, float, float] | None = None
    walls: bool = False


def scan(path: Path) -> Scan:
    """Reads the file once from end to end and verifies all of its checksums.

    Raises NotARecording if it is no recording, DamagedRecording if a checksum does not match or records are missing.
    """
    found = Scan(path)
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise NotARecording(f"{path} is no recording: it does not begin as an MCAP file does")
        channels: dict[int, str] = {}
        offset = 0
        try:
            for offset, opcode, body in _records(file, found):
                _take(found, channels, offset, opcode, body)
        except _WRONG as error:
            raise _damaged(path, offset, error) from error
    if not found.metadata and not any(found.entries.values()) and not found.truncated:
        raise NotARecording(f"{path} is an MCAP file, but no recording of squirm")
    return found


def read(entry: Entry, topic: str, cache: Cache) -> Snapshot:
    """The snapshot at `entry`, with its chunk's checksum verified once more."""
    messages = cache.messages(entry)
    try:
        snapshot = Snapshot(messages[entry.place].data)
    except (IndexError, NotASnapshot) as error:
        raise _damaged(entry.path, entry.offset, error) from error
    if (snapshot.kind, snapshot.step, snapshot.seq) != (topic, entry.step, entry.seq):
        raise DamagedRecording(f"{entry.path} has been changed since it was opened")
    return snapshot


class Cache:
    """The chunk that was read last: neighbouring snapshots may share one."""

    def __init__(self) -> None:
        self._key: tuple[Path, int] | None = None
        self._messages: list[Message] = []

    def messages(self, entry: Entry) -> list[Message]:
        """Messages of the chunk that holds `entry`."""
        key = (entry.path, entry.offset)
        if key != self._key:
            with entry.path.open("rb") as file:
                file.seek(entry.offset)
                head = file.read(_HEAD.size)
                if len(head) < _HEAD.size:
                    raise DamagedRecording(f"{entry.path} has become shorter since it was opened")
                opcode, length = _HEAD.unpack(head)
                body = file.read(length)
            try:
                if opcode != Opcode.CHUNK or len(body) < length:
                    raise DamagedRecording(f"{entry.path} has been changed since it was opened")
                self._messages = [r for r in _chunk(body) if isinstance(r, Message)]
            except _WRONG as error:
                raise _damaged(entry.path, entry.offset, error) from error
            self._key = key
        return self._messages


def _damaged(path: Path, offset: int, cause: object) -> DamagedRecording:
    if isinstance(cause, DamagedRecording):
        return cause
    what = (
        "the checksum does not match" if isinstance(cause, CRCValidationError) else str(cause) or type(cause).__name__
    )
    return DamagedRecording(f"{path} is damaged at byte {offset}: {what}; {_HINT}")


def _records(file: BinaryIO, found: Scan) -> Iterator[tuple[int, int, bytes]]:
    """Offset, opcode and content of every record of the data; the ends of data and file are checked here.

    A file that ends within a record is `truncated`, unless the end of a finished file is there: then it is damaged.
    """
    size = found.path.stat().st_size
    crc = zlib.crc32(MAGIC)
    summary: int | None = None
    known = {Opcode.HEADER}
    while True:
        offset = file.tell()
        head = file.read(_HEAD.size)
        opcode, length = _HEAD.unpack(head) if len(head) == _HEAD.size else (0, size)
        if length > size - offset - _HEAD.size:
            file.seek(max(size - len(MAGIC), 0))
            if file.read(len(MAGIC)) == MAGIC and size > 2 * len(MAGIC):
                raise _damaged(found.path, offset, "the length of a record is wrong")
            found.truncated = True
            return
        if opcode not in known:
            raise _damaged(found.path, offset, f"a record of kind {opcode} does not belong here")
        body = file.read(length)
        if len(body) < length:
            found.truncated = True
            return
        if opcode == Opcode.DATA_END:
            stored = DataEnd.read(ReadDataStream(BytesIO(body))).data_section_crc
            if stored not in (0, crc):
                raise _damaged(found.path, offset, "the checksum of all data does not match")
            summary, known = 0, _SUMMARY | {Opcode.FOOTER}
            continue
        if opcode == Opcode.FOOTER:
            footer = Footer.read(ReadDataStream(BytesIO(body)))
            computed = zlib.crc32(body[:16], zlib.crc32(head, summary or 0))
            if footer.summary_crc not in (0, computed):
                raise _damaged(found.path, offset, "the checksum of the summary does not match")
            rest = file.read()
            found.truncated = MAGIC.startswith(rest) and rest != MAGIC
            if not found.truncated and rest != MAGIC:
                raise _damaged(found.path, offset, "the file does not end as an MCAP file does")
            return
        if summary is not None:
            summary = zlib.crc32(body, zlib.crc32(head, summary))
            continue
        known = _DATA | {Opcode.DATA_END}
        crc = zlib.crc32(body, zlib.crc32(head, crc))
        yield offset, opcode, body


def _take(found: Scan, channels: dict[int, str], offset: int, opcode: int, body: bytes) -> None:
    """Notes what a record of the data holds."""
    stream = ReadDataStream(BytesIO(body))
    if opcode == Opcode.ATTACHMENT:
        (stored,) = struct.unpack("<I", body[-4:])
        if stored not in (0, zlib.crc32(body[:-4])):
            raise DamagedRecording(f"{found.path} is damaged at byte {offset}: an attachment's checksum does not match")
        attachment = Attachment.read(stream)
        found.attachments[attachment.name] = attachment.data
    elif opcode == Opcode.METADATA:
        metadata = Metadata.read(stream)
        if metadata.name == "squirm:run":
            found.metadata = metadata.metadata
    elif opcode == Opcode.CHANNEL:
        _channel(channels, Channel.read(stream))
    elif opcode == Opcode.MESSAGE:
        raise ValueError("a message outside a chunk has no checksum")
    elif opcode == Opcode.MESSAGE_INDEX:
        # A chunk whose kind was damaged would otherwise pass for an index.
        if len(body) < 6 or len(body) != 6 + struct.unpack_from("<I", body, 2)[0]:
            raise ValueError("an index of messages has a wrong length")
    elif opcode == Opcode.CHUNK:
        place = 0
        for record in _chunk(body):
            if isinstance(record, Channel):
                _channel(channels, record)
            elif isinstance(record, Message):
                topic = channels.get(record.channel_id)
                if topic is not None:
                    _snapshot(found, topic, offset, place, record.data)
                place += 1


def _channel(channels: dict[int, str], channel: Channel) -> None:
    topic = channel.topic.removeprefix(_PREFIX)
    if channel.topic.startswith(_PREFIX) and topic in TOPICS:
        channels[channel.id] = topic


def _snapshot(found: Scan, topic: str, offset: int, place: int, data: bytes) -> None:
    header = read_header(memoryview(data))
    if header.kind != topic:
        raise ValueError(f"a snapshot of {header.kind} among those of {topic}")
    if found.box_size is None:
        found.box_size, found.walls = header.box_size, header.walls
    found.entries[topic].append(
        Entry(found.path, offset, place, header.step, header.time, header.seq, header.every, header.run_id)
    )


def _chunk(body: bytes) -> list[McapRecord]:
    """Records of a chunk with its checksum verified; a chunk without one cannot be trusted."""
    chunk = Chunk.read(ReadDataStream(BytesIO(body)))
    if chunk.uncompressed_size > _LONGEST:
        raise ValueError("the length of a chunk is wrong")
    if chunk.uncompressed_crc == 0 and chunk.uncompressed_size > 0:
        raise ValueError("a chunk has no checksum")
    return breakup_chunk(chunk, validate_crc=True)

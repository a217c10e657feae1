"""What an MCAP file holds, found by walking over its records: for files that have no end yet.

A file that is being written, or whose writer was killed, has no summary. The walk reads the heads
of records only; chunks are opened where they hold the first message of a channel, since that is
where schemas and channels are.
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import breakup_chunk, get_chunk_data_stream
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

from teleopctl.errors import InvalidFileError

_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQI")
# What a record before the data's end may claim for itself; a chunk's content is not read for it.
_LARGEST_SMALL_RECORD = 2**28

# What decompressors and the library raise for bytes that are not what they should be.
BROKEN = (
    *(McapError, ZstdError, struct.error),
    *(ValueError, OSError, RuntimeError, EOFError, MemoryError),
)
"""What reading a broken chunk or record may raise."""


@dataclass
class Scan:
    """What a walk has found.

    Attributes:
        summary: As a finished file has it, with its statistics.
        end: Where the last whole record of the data ends, in bytes from the file's start.
        data_is_whole: Whether the data's end was found.
        is_finished: Whether the file's end is there too.
        missing_indexes: Message indexes of the last chunk, where the file ends among them; `end`
            is then the end of that chunk.
        bytes_beyond: Bytes that belong to no whole record, where the data's end is missing.
    """

    summary: Summary = field(default_factory=Summary)
    end: int = 0
    data_is_whole: bool = False
    is_finished: bool = False
    missing_indexes: list[MessageIndex] = field(default_factory=list)
    bytes_beyond: int = 0


def scan(path: Path) -> Scan:
    """Walk over a file.

    Raises:
        InvalidFileError: It is not an MCAP file, or cannot be read.
    """
    try:
        with path.open("rb") as stream:
            return _Walk(path, stream).walk()
    except OSError as error:
        raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error


class _Times(NamedTuple):
    """How many messages, and from when to when, in nanoseconds since the epoch."""

    messages: int
    first_ns: int
    last_ns: int


def _note(every: dict[int, _Times], channel_id: int, times_ns: list[int]) -> None:
    if times_ns:
        _add_times(every, channel_id, _Times(len(times_ns), min(times_ns), max(times_ns)))


def _add_times(every: dict[int, _Times], channel_id: int, times: _Times) -> None:
    known = every.get(channel_id)
    every[channel_id] = (
        times
        if known is None
        else _Times(
            known.messages + times.messages,
            min(known.first_ns, times.first_ns),
            max(known.last_ns, times.last_ns),
        )
    )


class _Walk:
    def __init__(self, path: Path, stream: BinaryIO) -> None:
        self._path = path
        self._stream = stream
        self._size = os.fstat(stream.fileno()).st_size
        self._scan = Scan()
        self._statistics = Statistics(
            attachment_count=0,
            channel_count=0,
            channel_message_counts={},
            chunk_count=0,
            message_count=0,
            message_end_time=0,
            message_start_time=0,
            metadata_count=0,
            schema_count=0,
        )
        self._scan.summary.statistics = self._statistics
        # Chunks that were not opened, since no channel was missing.
        self._unopened: list[ChunkIndex] = []
        # Messages of each chunk by channel; of a file without chunks, all under None.
        self._times: dict[int | None, dict[int, _Times]] = {}

    def walk(self) -> Scan:
        if self._stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise InvalidFileError(f"{self._path} is not an MCAP file")
        found = self._scan
        found.end = len(MCAP0_MAGIC)
        try:
            for opcode, start, length in self._records():
                if opcode == Opcode.DATA_END:
                    found.data_is_whole = True
                    break
                self._take(opcode, start, length)
                found.end = start + _HEAD.size + length
        except BROKEN:
            pass  # what stands behind a broken record cannot be found
        self._open_chunks_without_index()
        self._stream.seek(-len(MCAP0_MAGIC), io.SEEK_END)
        found.is_finished = found.data_is_whole and self._stream.read() == MCAP0_MAGIC
        if not found.data_is_whole:
            found.bytes_beyond = self._size - found.end
        self._count()
        self._statistics.schema_count = len(found.summary.schemas)
        self._statistics.channel_count = len(found.summary.channels)
        return found

    def _records(self) -> Iterator[tuple[int, int, int]]:
        """Opcode, start and length of content of each whole record."""
        start = self._scan.end
        while start + _HEAD.size <= self._size:
            self._stream.seek(start)
            opcode, length = _HEAD.unpack(self._stream.read(_HEAD.size))
            if not 0 < opcode <= Opcode.DATA_END or start + _HEAD.size + length > self._size:
                return
            yield opcode, start, length
            start += _HEAD.size + length

    def _take(self, opcode: int, start: int, length: int) -> None:
        if opcode == Opcode.CHUNK:
            self._take_chunk(start, length)
            return
        if opcode == Opcode.MESSAGE_INDEX:
            self._take_message_index(start, self._content(length))
        elif opcode == Opcode.SCHEMA:
            self._add(Schema.read(self._content(length)))
        elif opcode == Opcode.CHANNEL:
            self._add(Channel.read(self._content(length)))
        elif opcode == Opcode.MESSAGE:
            # A file without chunks has them between the other records.
            message = Message.read(self._content(length), length)
            _note(self._times.setdefault(None, {}), message.channel_id, [message.log_time])
        elif opcode == Opcode.ATTACHMENT:
            self._take_attachment(start, length)
        elif opcode == Opcode.METADATA:
            metadata = Metadata.read(self._content(length))
            self._statistics.metadata_count += 1
            self._scan.summary.metadata_indexes.append(
                MetadataIndex(offset=start, length=_HEAD.size + length, name=metadata.name)
            )

    def _take_chunk(self, start: int, length: int) -> None:
        first_ns, last_ns, uncompressed, _ = _CHUNK_HEAD.unpack(self._stream.read(_CHUNK_HEAD.size))
        head = ReadDataStream(self._stream)
        compression = head.read_prefixed_string()
        compressed = head.read8()
        if _CHUNK_HEAD.size + head.count + compressed != length:
            raise ValueError("a chunk is not as long as its record")
        index = ChunkIndex(
            chunk_length=_HEAD.size + length,
            chunk_start_offset=start,
            compression=compression,
            compressed_size=compressed,
            message_end_time=last_ns,
            message_index_length=0,
            message_index_offsets={},
            message_start_time=first_ns,
            uncompressed_size=uncompressed,
        )
        self._scan.summary.chunk_indexes.append(index)
        self._unopened.append(index)
        self._times[start] = {}

    def _take_message_index(self, start: int, content: ReadDataStream) -> None:
        found = MessageIndex.read(content)
        chunk = self._scan.summary.chunk_indexes[-1]
        chunk.message_index_offsets[found.channel_id] = start
        chunk.message_index_length += _HEAD.size + content.count
        while found.channel_id not in self._scan.summary.channels and self._unopened:
            # Channels that have no message yet stand in an earlier chunk.
            for record in read_chunk(self._stream, self._unopened.pop()):
                if isinstance(record, Schema | Channel):
                    self._add(record)
        times = [time_ns for time_ns, _ in found.records]
        _note(self._times[chunk.chunk_start_offset], found.channel_id, times)

    def _open_chunks_without_index(self) -> None:
        """Look into chunks that have no index, and the last one of an unfinished file."""
        chunks = self._scan.summary.chunk_indexes
        last = chunks[-1] if chunks and not self._scan.data_is_whole else None
        for chunk in [c for c in chunks if not c.message_index_offsets or c is last]:
            indexed = self._times[chunk.chunk_start_offset]
            times: dict[int, _Times] = {}
            try:
                for record in read_chunk(self._stream, chunk, checked=True):
                    if isinstance(record, Message):
                        _note(times, record.channel_id, [record.log_time])
                    else:
                        self._add(record)
            except BROKEN:
                if chunk is last:
                    self._drop(chunk)
                continue
            self._times[chunk.chunk_start_offset] = times
            if chunk is last and times.keys() != indexed.keys():
                self._scan.end = chunk.chunk_start_offset + chunk.chunk_length
                self._scan.missing_indexes = message_indexes(self._stream, chunk)

    def _drop(self, chunk: ChunkIndex) -> None:
        """Leave the last chunk out: not all of it reached the disk."""
        self._scan.summary.chunk_indexes.pop()
        del self._times[chunk.chunk_start_offset]
        self._scan.end = chunk.chunk_start_offset

    def _take_attachment(self, start: int, length: int) -> None:
        attachment = Attachment.read(self._content(length))
        self._statistics.attachment_count += 1
        self._scan.summary.attachment_indexes.append(
            AttachmentIndex(
                offset=start,
                length=_HEAD.size + length,
                log_time=attachment.log_time,
                create_time=attachment.create_time,
                data_size=len(attachment.data),
                name=attachment.name,
                media_type=attachment.media_type,
            )
        )

    def _add(self, record: Schema | Channel) -> None:
        if isinstance(record, Schema):
            self._scan.summary.schemas.setdefault(record.id, record)
        else:
            self._scan.summary.channels.setdefault(record.id, record)

    def _count(self) -> None:
        statistics = self._statistics
        statistics.chunk_count = len(self._scan.summary.chunk_indexes)
        every: dict[int, _Times] = {}
        for of_chunk in self._times.values():
            for channel_id, times in of_chunk.items():
                _add_times(every, channel_id, times)
        statistics.channel_message_counts = {id_: times.messages for id_, times in every.items()}
        statistics.message_count = sum(times.messages for times in every.values())
        statistics.message_start_time = min((t.first_ns for t in every.values()), default=0)
        statistics.message_end_time = max((t.last_ns for t in every.values()), default=0)

    def _content(self, length: int) -> ReadDataStream:
        if length > _LARGEST_SMALL_RECORD:
            raise ValueError("a record is larger than what it may hold")
        return ReadDataStream(io.BytesIO(self._stream.read(length)))


def read_chunk(
    stream: BinaryIO, index: ChunkIndex, *, checked: bool = False
) -> list[Schema | Channel | Message]:
    """Return the records of a chunk.

    Args:
        stream: The file; it is left somewhere.
        index: Where the chunk is.
        checked: Whether to compare the checksum.

    Raises:
        Exception: One of `BROKEN`: the chunk is not what its index says.
    """
    stream.seek(index.chunk_start_offset + _HEAD.size)
    chunk = Chunk.read(ReadDataStream(stream))
    records = breakup_chunk(chunk, validate_crc=checked)
    return [record for record in records if isinstance(record, Schema | Channel | Message)]


def read_latest(
    stream: BinaryIO, index: ChunkIndex, channels: Iterable[int], end_ns: int, most: int
) -> list[Message]:
    """Return the last messages of channels before a log time, and read no others.

    Args:
        stream: The file; it is left somewhere.
        index: Where the chunk is; it has message indexes.
        channels: The channels' numbers.
        end_ns: The log time, in nanoseconds since the epoch.
        most: How many.

    Raises:
        Exception: One of `BROKEN`: the chunk is not what its index says.
    """
    entries: list[tuple[int, int]] = []
    for offset in (index.message_index_offsets.get(id_) for id_ in channels):
        if offset is not None:
            stream.seek(offset + _HEAD.size)
            records = MessageIndex.read(ReadDataStream(stream)).records
            entries += [entry for entry in records if entry[0] < end_ns]
    if not entries:
        return []
    stream.seek(index.chunk_start_offset + _HEAD.size)
    content, size = get_chunk_data_stream(Chunk.read(ReadDataStream(stream)))
    data = content.read(size)
    found = []
    for _, offset in sorted(entries)[-most:]:
        _, length = _HEAD.unpack_from(data, offset)
        start = offset + _HEAD.size
        found.append(Message.read(ReadDataStream(io.BytesIO(data[start : start + length])), length))
    return found


def message_indexes(stream: BinaryIO, index: ChunkIndex) -> list[MessageIndex]:
    """Make the message indexes of a chunk anew from its content.

    Args:
        stream: The file; it is left somewhere.
        index: Where the chunk is.

    Raises:
        Exception: One of `BROKEN`: the chunk is not what its index says.
    """
    stream.seek(index.chunk_start_offset + _HEAD.size)
    content, size = get_chunk_data_stream(Chunk.read(ReadDataStream(stream)))
    entries: dict[int, list[tuple[int, int]]] = {}
    while content.count < size:
        offset = content.count
        opcode, length = _HEAD.unpack(content.read(_HEAD.size))
        if opcode == Opcode.MESSAGE:
            message = Message.read(content, length)
            entries.setdefault(message.channel_id, []).append((message.log_time, offset))
        else:
            content.read(length)
    return [MessageIndex(channel_id, records) for channel_id, records in entries.items()]

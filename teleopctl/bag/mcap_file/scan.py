"""Scan of an MCAP file record by record, for files that have no summary (yet).

A file that is being written, or whose writer was killed, has no summary. The scan reads only the
headers of records. It opens chunks with the first message of a channel, since these contain schemas
and channels.
"""

from __future__ import annotations

import contextlib
import io
import mmap
import os
import re
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Message,
    MessageIndex,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.summary import Summary

from teleopctl.bag.mcap_file.broken_chunks import recover_chunk
from teleopctl.bag.mcap_file.chunk import (
    BROKEN,
    CHUNK_HEAD,
    HEAD,
    MAGIC,
    MESSAGE_HEAD,
    UnpackedChunks,
    read_chunk,
    read_compression,
    read_record,
    rebuild_message_indexes,
)
from teleopctl.errors import InvalidFileError

_ATTACHMENT_TIMES = struct.Struct("<QQ")
MAGIC_BYTES = len(MAGIC)
"""Number of magic bytes at the start and the end of a file."""

# Records with opcodes from here on are private to a program and ignored by others.
_FIRST_PRIVATE_OPCODE = 0x80
# Largest length of a truncated record in bytes; a larger length is a damaged one.
_LARGEST_RECORD = 2**32
# Pattern to find the next chunk after a broken record: record header, times, size, checksum, and
# the name of a compression.
_CHUNK = re.compile(rb"\x06.{36}(?:\x04\0\0\0zstd|\x03\0\0\0lz4|\0\0\0\0)", re.DOTALL)


@dataclass
class Scan:
    """Result of `scan`: summary of an MCAP file's records, and where it is broken or cut off.

    Attributes:
        summary: Summary as in a finished file, with statistics.
        end: End of the last complete record of the data section, in bytes from the file's start.
        data_is_whole: Whether the data end record was found.
        is_finished: Whether the data end record and the closing magic bytes were found.
        missing_indexes: Message indexes of the last chunk, if the file does not have all of them;
            `end` is then the end of that chunk.
        bytes_beyond: Number of bytes after the last complete record, if the data end record is
            missing.
        tail_is_cut_off: Whether these bytes are those after a killed writer or a power failure: the
            beginning of a record, or zeros only.
        gaps: First and end byte of each broken part that is followed by a complete chunk.
        broken: Offset and error of each record with a valid length and invalid content.
        times: Numbers and times of messages by channel ID, for each chunk by its offset; those of
            messages outside chunks under None.
    """

    summary: Summary = field(default_factory=Summary)
    end: int = 0
    data_is_whole: bool = False
    is_finished: bool = False
    missing_indexes: list[MessageIndex] = field(default_factory=list)
    bytes_beyond: int = 0
    tail_is_cut_off: bool = True
    gaps: list[tuple[int, int]] = field(default_factory=list)
    broken: list[tuple[int, str]] = field(default_factory=list)
    times: dict[int | None, dict[int, Times]] = field(default_factory=dict)

    def add_description(self, record: Schema | Channel) -> None:
        """Add a schema or channel record to the summary, unless its id is known."""
        if isinstance(record, Schema):
            self.summary.schemas.setdefault(record.id, record)
        else:
            self.summary.channels.setdefault(record.id, record)

    def update_statistics(self, messages: Iterable[Message] = ()) -> None:
        """Set the summary's statistics from the scanned and further given messages."""
        statistics = self.summary.statistics
        assert statistics is not None
        statistics.chunk_count = len(self.summary.chunk_indexes)
        every: dict[int, Times] = {}
        for of_chunk in self.times.values():
            for channel_id, times in of_chunk.items():
                _add_times(every, channel_id, times)
        for message in messages:
            _note(every, message.channel_id, [message.log_time])
        statistics.schema_count = len(self.summary.schemas)
        statistics.channel_count = len(self.summary.channels)
        statistics.channel_message_counts = {id_: times.messages for id_, times in every.items()}
        statistics.message_count = sum(times.messages for times in every.values())
        statistics.message_start_time = min((t.first_ns for t in every.values()), default=0)
        statistics.message_end_time = max((t.last_ns for t in every.values()), default=0)


def scan(path: Path) -> Scan:
    """Read all record headers of an MCAP file; return a `Scan`: summary and places of defects.

    Raises:
        InvalidFileError: The file is no MCAP file, or cannot be read.
    """
    try:
        with path.open("rb") as stream:
            return _Walk(path, stream).walk()
    except OSError as error:
        raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error


class Times(NamedTuple):
    """Number of messages of a channel, with their first and last log time in nanoseconds."""

    messages: int
    first_ns: int
    last_ns: int


def _note(every: dict[int, Times], channel_id: int, times_ns: list[int]) -> None:
    if times_ns:
        _add_times(every, channel_id, Times(len(times_ns), min(times_ns), max(times_ns)))


def _add_times(every: dict[int, Times], channel_id: int, times: Times) -> None:
    known = every.get(channel_id)
    every[channel_id] = (
        times
        if known is None
        else Times(
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
        # Chunks not opened yet, since no channel was missing.
        self._unopened: list[ChunkIndex] = []
        self._unpacked = UnpackedChunks(stream)
        self._times = self._scan.times

    def walk(self) -> Scan:
        if self._stream.read(MAGIC_BYTES) != MAGIC:
            raise InvalidFileError(f"{self._path} is not an MCAP file")
        found = self._scan
        found.end = MAGIC_BYTES
        for opcode, start, length in self._records():
            if opcode == Opcode.DATA_END:
                found.data_is_whole = True
                break
            try:
                self._take(opcode, start, length)
            except BROKEN as error:
                found.broken.append((start, str(error) or type(error).__name__))
            found.end = start + HEAD.size + length
        self._open_chunks_without_index()
        self._stream.seek(-MAGIC_BYTES, io.SEEK_END)
        found.is_finished = found.data_is_whole and self._stream.read() == MAGIC
        if not found.data_is_whole:
            found.bytes_beyond = self._size - found.end
        found.update_statistics()
        return found

    def _records(self) -> Iterator[tuple[int, int, int]]:
        """Yield opcode, offset and content length of each complete record."""
        start = self._scan.end
        while start < self._size:
            head = self._head(start)
            if head is None:
                behind = self._next_chunk(start + 1)
                if behind is None:
                    self._scan.tail_is_cut_off = self._is_cut_off(start)
                    return
                self._scan.gaps.append((start, behind))
                start = behind
                continue
            yield head[0], start, head[1]
            start += HEAD.size + head[1]

    def _head(self, start: int) -> tuple[int, int] | None:
        """Return opcode and length of the record at an offset; None if missing or incomplete."""
        self._stream.seek(start)
        data = self._stream.read(HEAD.size)
        if len(data) < HEAD.size:
            return None
        opcode, length = HEAD.unpack(data)
        is_known = 0 < opcode <= Opcode.DATA_END or opcode >= _FIRST_PRIVATE_OPCODE
        if not is_known or start + HEAD.size + length > self._size:
            return None
        return opcode, length

    def _next_chunk(self, start: int) -> int | None:
        """Return the offset of the next chunk with a consistent length; None if there is none."""
        with mmap.mmap(self._stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            while (match := _CHUNK.search(data, start)) is not None:
                start = match.start()
                head = self._head(start)
                with contextlib.suppress(*BROKEN):
                    if head is not None:
                        self._stream.seek(start + HEAD.size + CHUNK_HEAD.size)
                        read_compression(self._stream, head[1])
                        return start
                start += 1
        return None

    def _is_cut_off(self, start: int) -> bool:
        """Return whether the bytes from an offset are a truncated record, or zeros only."""
        self._stream.seek(start)
        head = self._stream.read(HEAD.size)
        if len(head) < HEAD.size:
            return True
        opcode, length = HEAD.unpack(head)
        if 0 < opcode <= Opcode.DATA_END:
            return bool(length <= _LARGEST_RECORD)
        if any(head):
            return False
        while block := self._stream.read(2**20):
            if block.count(0) != len(block):
                return False
        return True

    def _take(self, opcode: int, start: int, length: int) -> None:
        if opcode == Opcode.CHUNK:
            self._take_chunk(start, length)
            return
        if opcode == Opcode.MESSAGE_INDEX:
            self._take_message_index(start, length)
        elif opcode == Opcode.SCHEMA:
            self._scan.add_description(read_record(Schema, self._stream.read(length)))
        elif opcode == Opcode.CHANNEL:
            self._scan.add_description(read_record(Channel, self._stream.read(length)))
        elif opcode == Opcode.MESSAGE:
            # Messages outside chunks.
            channel, _, log_ns, _ = MESSAGE_HEAD.unpack(self._stream.read(MESSAGE_HEAD.size))
            _note(self._times.setdefault(None, {}), channel, [log_ns])
        elif opcode == Opcode.ATTACHMENT:
            self._take_attachment(start, length)
        elif opcode == Opcode.METADATA:
            self._take_metadata(start, length)

    def _take_chunk(self, start: int, length: int) -> None:
        first_ns, last_ns, uncompressed, _ = CHUNK_HEAD.unpack(self._stream.read(CHUNK_HEAD.size))
        compression, compressed = read_compression(self._stream, length)
        index = ChunkIndex(
            chunk_length=HEAD.size + length,
            chunk_start_offset=start,
            compression=compression,
            compressed_size=compressed,
            message_end_time=last_ns,
            message_index_length=0,
            message_index_offsets={},
            message_start_time=first_ns,
            uncompressed_size=uncompressed,
        )
        self._unpacked.add(index)
        self._scan.summary.chunk_indexes.append(index)
        self._unopened.append(index)
        self._times[start] = {}

    def _take_message_index(self, start: int, length: int) -> None:
        found = read_record(MessageIndex, self._stream.read(length))
        if not self._scan.summary.chunk_indexes:
            raise ValueError("a message index has no chunk before it")
        chunk = self._scan.summary.chunk_indexes[-1]
        chunk.message_index_offsets[found.channel_id] = start
        chunk.message_index_length += HEAD.size + length
        while found.channel_id not in self._scan.summary.channels and self._unopened:
            # A channel may be in an earlier chunk, which had no message of it.
            with contextlib.suppress(*BROKEN):
                for record in self._descriptions(self._unopened.pop()):
                    self._scan.add_description(record)
        times = [time_ns for time_ns, _ in found.records]
        _note(self._times[chunk.chunk_start_offset], found.channel_id, times)

    def _descriptions(self, chunk: ChunkIndex) -> Sequence[Schema | Channel]:
        """Return schemas and channels of a chunk; the readable ones if the chunk is broken."""
        try:
            records = read_chunk(self._stream, chunk)
        except BROKEN:
            return recover_chunk(self._stream, chunk).descriptions
        return [record for record in records if isinstance(record, Schema | Channel)]

    def _open_chunks_without_index(self) -> None:
        """Read the chunks without message indexes, and the last one of an unfinished file."""
        chunks = self._scan.summary.chunk_indexes
        last = chunks[-1] if chunks and not self._scan.data_is_whole else None
        for chunk in [c for c in chunks if not c.message_index_offsets or c is last]:
            start = chunk.chunk_start_offset
            indexed = self._times[start]
            times: dict[int, Times] = {}
            try:
                for record in read_chunk(self._stream, chunk):
                    if isinstance(record, Message):
                        _note(times, record.channel_id, [record.log_time])
                    else:
                        self._scan.add_description(record)
            except BROKEN:
                # Followed by complete records, the chunk is damaged; otherwise it is truncated.
                if chunk is last and self._scan.end == start + chunk.chunk_length:
                    self._drop(chunk)
                continue
            self._times[start] = times
            end = start + chunk.chunk_length
            is_end = self._scan.end == end + chunk.message_index_length
            if chunk is last and is_end and times.keys() != indexed.keys():
                self._scan.end = end
                self._scan.missing_indexes = rebuild_message_indexes(self._stream, chunk)

    def _drop(self, chunk: ChunkIndex) -> None:
        """Remove the last chunk from the scan, since it was not written completely."""
        self._scan.summary.chunk_indexes.pop()
        del self._times[chunk.chunk_start_offset]
        self._scan.end = chunk.chunk_start_offset

    def _take_attachment(self, start: int, length: int) -> None:
        # The data, which may be large, is not read.
        log_ns, create_ns = _ATTACHMENT_TIMES.unpack(self._stream.read(_ATTACHMENT_TIMES.size))
        head = ReadDataStream(self._stream)
        name, media_type = self._text(length), self._text(length)
        size = head.read8()
        self._statistics.attachment_count += 1
        self._scan.summary.attachment_indexes.append(
            AttachmentIndex(
                offset=start,
                length=HEAD.size + length,
                log_time=log_ns,
                create_time=create_ns,
                data_size=size,
                name=name,
                media_type=media_type,
            )
        )

    def _take_metadata(self, start: int, length: int) -> None:
        name = self._text(length)
        self._statistics.metadata_count += 1
        self._scan.summary.metadata_indexes.append(
            MetadataIndex(offset=start, length=HEAD.size + length, name=name)
        )

    def _text(self, limit: int) -> str:
        """Read a text with its length; raise if the length exceeds a limit in bytes."""
        length = ReadDataStream(self._stream).read4()
        if length > limit:
            raise ValueError("a text is longer than its record")
        return self._stream.read(length).decode()

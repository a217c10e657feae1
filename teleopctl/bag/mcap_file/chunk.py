"""Reading the chunks of an MCAP file, with every length checked before it is used.

The mcap library does not check the lengths in records: a message shorter than its header takes all
following bytes, and a chunk may state any size. So this module reads the headers itself.
"""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Iterable, Iterator
from typing import BinaryIO, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Message, MessageIndex, Schema
from zstandard import ZstdError

from teleopctl.base.budget import (
    MOST_RECORDS,
    SMALLEST_RECORD_BYTES,
    UNPACKED_RATIO,
    BudgetError,
    Tally,
    check_unpacked,
    may_be_unpacked,
    tally_of_unpacked,
)
from teleopctl.errors import InvalidFileError

MAGIC = b"\x89MCAP0\r\n"
"""First and last bytes of a file. Defined here because importing the library's writer, which has
them, would take half of the time to read a small file."""
HEAD = struct.Struct("<BQ")
"""Header of any record: opcode, and length of the content in bytes."""
CHUNK_HEAD = struct.Struct("<QQQI")
"""Start of a chunk's content: first and last log time, uncompressed size and checksum."""
MESSAGE_HEAD = struct.Struct("<HIQQ")
"""Start of a message's content: channel, sequence number, log time, publish time."""

# Chunks may be large: the library's writer makes a chunk for each message larger than a chunk.
LARGEST_CHUNK = 2**32
"""Largest size in bytes that a chunk may state, compressed or not."""

# Errors that decompressors and the library raise for invalid bytes.
BROKEN = (
    *(McapError, ZstdError, struct.error),
    *(ValueError, OSError, RuntimeError, EOFError, MemoryError, OverflowError, LookupError),
)
"""Errors that reading a broken chunk or record may raise."""

_Record = TypeVar("_Record", Schema, Channel, MessageIndex)


class UnpackedChunks:
    """Counter of the decompressed size of a file's chunks, which limits the total.

    Args:
        stream: Open MCAP file.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._path = stream.name
        self._unpacked = tally_of_unpacked(os.fstat(stream.fileno()).st_size)

    def add(self, index: ChunkIndex) -> None:
        """Add the decompressed size of a chunk; raise if the total becomes too large.

        Raises:
            InvalidFileError: The chunks together become too large.
        """
        if not may_be_unpacked(index.uncompressed_size, index.compressed_size):
            return  # reading the chunk itself raises an error
        try:
            self._unpacked.add(index.uncompressed_size)
        except BudgetError as error:
            raise InvalidFileError(
                f"Cannot read {self._path}: {error}",
                hint=f"mcap decompress {self._path} -o FILE, of the mcap project, unpacks it all"
                " the same.",
            ) from error


def read_chunk(stream: BinaryIO, index: ChunkIndex) -> list[Schema | Channel | Message]:
    """Return the schema, channel and message records of an MCAP chunk.

    Args:
        stream: Open MCAP file; its position changes.
        index: Chunk index record of the chunk.

    Raises:
        Exception: An error of `BROKEN`, if the chunk is damaged or contradicts its index.
    """
    data = read_chunk_content(stream, index)
    found: list[Schema | Channel | Message] = []
    for opcode, start, end in iter_records(data):
        if opcode == Opcode.MESSAGE:
            found.append(read_message(data, start, end))
        elif opcode == Opcode.SCHEMA:
            found.append(read_record(Schema, data[start:end]))
        elif opcode == Opcode.CHANNEL:
            found.append(read_record(Channel, data[start:end]))
    return found


def read_latest(
    stream: BinaryIO, index: ChunkIndex, channels: Iterable[int], end_ns: int, most: int
) -> list[Message]:
    """Return up to `most` last messages of channels in a chunk before a log time, oldest first.

    Args:
        stream: Open MCAP file; its position changes.
        index: Chunk index record of a chunk with message indexes.
        channels: IDs of the channels.
        end_ns: Log time before which messages are searched, in nanoseconds since the epoch.
        most: Largest number of messages.

    Raises:
        Exception: An error of `BROKEN`, if the chunk is damaged or contradicts its index.
    """
    entries: list[tuple[int, int]] = []
    for offset in (index.message_index_offsets.get(id_) for id_ in channels):
        if offset is not None:
            records = read_message_index(stream, offset).records
            entries += [entry for entry in records if entry[0] < end_ns]
    if not entries:
        return []
    data = read_chunk_content(stream, index)
    found = []
    for _, offset in sorted(entries)[-most:]:
        opcode, length = HEAD.unpack_from(data, offset)
        start = offset + HEAD.size
        if opcode != Opcode.MESSAGE or length < MESSAGE_HEAD.size or start + length > len(data):
            raise ValueError("its index does not lead to a message")
        found.append(read_message(data, start, start + length))
    return found


def read_message_index(stream: BinaryIO, offset: int) -> MessageIndex:
    """Read and return the message index record at an offset of the file.

    Raises:
        Exception: An error of `BROKEN`, if there is no valid message index.
    """
    stream.seek(offset)
    opcode, length = HEAD.unpack(stream.read(HEAD.size))
    if opcode != Opcode.MESSAGE_INDEX:
        raise ValueError("there is no message index")
    if offset + HEAD.size + length > os.fstat(stream.fileno()).st_size:
        raise ValueError("a message index goes beyond the end of the file")
    return read_record(MessageIndex, stream.read(length))


def rebuild_message_indexes(stream: BinaryIO, index: ChunkIndex) -> list[MessageIndex]:
    """Return the message index records of a chunk, computed from the messages in the chunk.

    Args:
        stream: Open MCAP file; its position changes.
        index: Chunk index record of the chunk.

    Raises:
        Exception: An error of `BROKEN`, if the chunk is damaged or contradicts its index.
    """
    data = read_chunk_content(stream, index)
    entries: dict[int, list[tuple[int, int]]] = {}
    for opcode, start, _ in iter_records(data):
        if opcode == Opcode.MESSAGE:
            channel, _, log_ns, _ = MESSAGE_HEAD.unpack_from(data, start)
            entries.setdefault(channel, []).append((log_ns, start - HEAD.size))
    return [MessageIndex(channel_id, records) for channel_id, records in entries.items()]


def read_record(kind: type[_Record], data: bytes) -> _Record:
    """Parse and return the content of a schema, channel or message index record.

    Raises:
        Exception: An error of `BROKEN`, if the content is invalid.
    """
    stream = ReadDataStream(io.BytesIO(data))
    record: _Record = kind.read(stream)
    if stream.count > len(data):
        raise ValueError("a record is longer than its stated length")
    return record


def read_message(data: bytes, start: int, end: int) -> Message:
    """Parse and return the message record whose content is between two offsets of a chunk."""
    channel, sequence, log_ns, publish_ns = MESSAGE_HEAD.unpack_from(data, start)
    return Message(channel, log_ns, data[start + MESSAGE_HEAD.size : end], publish_ns, sequence)


def iter_records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, content start and content end of each record in decompressed chunk data.

    Raises:
        ValueError: The length of a record is wrong, or the chunk has too many records.
        struct.error: The data ends within the header of a record.
    """
    if len(data) > MOST_RECORDS * SMALLEST_RECORD_BYTES:
        _count_records(data)
    offset = 0
    while offset < len(data):
        opcode, length = HEAD.unpack_from(data, offset)
        start = offset + HEAD.size
        offset = start + length
        if offset > len(data):
            raise ValueError("a record goes beyond the end of its chunk")
        if opcode == Opcode.MESSAGE and length < MESSAGE_HEAD.size:
            raise ValueError("a message is shorter than its header")
        yield opcode, start, offset


def _count_records(data: bytes) -> None:
    """Raise if a chunk has too many records, before objects are created from them."""
    records = Tally("records", MOST_RECORDS)
    offset = 0
    while offset + HEAD.size <= len(data):
        offset += HEAD.size + HEAD.unpack_from(data, offset)[1]
        records.add()


def read_chunk_content(stream: BinaryIO, index: ChunkIndex, *, checked: bool = True) -> bytes:
    """Return the decompressed content of an MCAP chunk; raise if it is broken.

    Args:
        stream: Open MCAP file; its position changes.
        index: Chunk index record of the chunk.
        checked: Whether to compare the checksum.

    Raises:
        Exception: An error of `BROKEN`, if the chunk is damaged or contradicts its index.
    """
    offset = index.chunk_start_offset
    stream.seek(offset)
    opcode, length = HEAD.unpack(stream.read(HEAD.size))
    if opcode != Opcode.CHUNK:
        raise ValueError("there is no chunk")
    if offset + HEAD.size + length > os.fstat(stream.fileno()).st_size:
        raise ValueError("it goes beyond the end of the file")
    _, _, size, checksum = CHUNK_HEAD.unpack(stream.read(CHUNK_HEAD.size))
    compression, compressed = read_compression(stream, length)
    if size > LARGEST_CHUNK or (not compression and compressed != size):
        raise ValueError(f"it claims {size} bytes")
    if compression:
        check_unpacked(size, compressed)
        # `UnpackedChunks` has counted the size in the chunk index.
        if size != index.uncompressed_size and size > UNPACKED_RATIO * compressed:
            raise ValueError(f"it claims {size} bytes, and its index {index.uncompressed_size}")
    data = _decompressed(compression, stream.read(compressed), size)
    if len(data) != size:
        raise ValueError(f"it has {len(data)} bytes in place of {size}")
    if checked and checksum and zlib.crc32(data) != checksum:
        raise ValueError("its checksum is wrong")
    return data


def read_compression(stream: BinaryIO, length: int) -> tuple[str, int]:
    """Return compression name and compressed size of a chunk, read at the stream's position.

    Raises:
        Exception: An error of `BROKEN`, if the sizes contradict the length of the record.
    """
    (name_length,) = struct.unpack("<I", stream.read(4))
    if name_length > length:
        raise ValueError("the name of its compression is longer than it is")
    name = stream.read(name_length).decode()
    (compressed,) = struct.unpack("<Q", stream.read(8))
    if CHUNK_HEAD.size + 4 + name_length + 8 + compressed != length:
        raise ValueError("a chunk is not as long as its record")
    return name, compressed


def _decompressed(compression: str, data: bytes, size: int) -> bytes:
    if compression == "":
        return data
    if compression == "zstd":
        import zstandard

        # zstd allocates the size that the frame states, which must be that of the chunk.
        if zstandard.frame_content_size(data) not in (-1, size):
            raise ValueError("its compressed data has another size than stated")
        return zstandard.decompress(data, size)
    if compression == "lz4":
        import lz4.frame  # type: ignore[import-untyped]  # it has no stubs

        if lz4.frame.get_frame_info(data)["content_size"] not in (0, size):
            raise ValueError("its compressed data has another size than stated")
        decompressor = lz4.frame.LZ4FrameDecompressor()
        unpacked: bytes = decompressor.decompress(data, size)
        if not decompressor.eof and decompressor.decompress(b"", 1):
            raise ValueError(f"its compressed data becomes larger than the stated {size} bytes")
        return unpacked
    raise ValueError(f"its compression '{compression}' is not known")

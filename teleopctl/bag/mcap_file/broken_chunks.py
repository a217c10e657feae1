"""Recovery of messages from broken chunks: with a wrong checksum, or cut off by the end of file.

After a power failure, a file may have its full length, with zeros in place of data that was not
written to the disk: such a file is read up to the zeros.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Collection
from typing import BinaryIO, NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Message, Schema

from teleopctl.bag.mcap_file.chunk import (
    BROKEN,
    CHUNK_HEAD,
    HEAD,
    MESSAGE_HEAD,
    iter_records,
    read_chunk_content,
    read_compression,
    read_message,
    read_message_index,
    read_record,
)
from teleopctl.bag.mcap_file.chunk_builder import ChunkBuilder, ChunkSettings, Compression
from teleopctl.bag.mcap_file.summary import encode_record
from teleopctl.base.budget import check_unpacked


class RecoveredChunk(NamedTuple):
    """Records recovered from an MCAP chunk whose checksum is wrong.

    Attributes:
        descriptions: Schemas and channels.
        messages: Messages, whose data may have changed.
        message_count: Number of messages that the chunk had.
    """

    descriptions: list[Schema | Channel]
    messages: list[Message]
    message_count: int


def recover_chunk(stream: BinaryIO, index: ChunkIndex) -> RecoveredChunk:
    """Return the `RecoveredChunk` of a chunk with a wrong checksum: records that fit its indexes.

    The message indexes after the chunk give offset, channel and time of each message. A record that
    agrees with them is a message, also after a record with a wrong length.

    Args:
        stream: Open MCAP file; its position changes.
        index: Chunk index record of the chunk.

    Raises:
        Exception: An error of `BROKEN`, if the chunk cannot be decompressed.
    """
    data = read_chunk_content(stream, index, checked=False)
    descriptions: list[Schema | Channel] = []
    walked: dict[int, tuple[int, int]] = {}
    # Up to the first broken record.
    with contextlib.suppress(*BROKEN):
        for opcode, start, end in iter_records(data):
            if opcode == Opcode.MESSAGE:
                channel, _, log_ns, _ = MESSAGE_HEAD.unpack_from(data, start)
                walked[start - HEAD.size] = channel, log_ns
            elif opcode == Opcode.SCHEMA:
                descriptions.append(read_record(Schema, data[start:end]))
            elif opcode == Opcode.CHANNEL:
                descriptions.append(read_record(Channel, data[start:end]))
    indexed = _indexed_messages(stream, index) or walked
    offsets = sorted(indexed)
    messages = []
    for offset, following in zip(offsets, [*offsets[1:], len(data)], strict=True):
        message = _message_at(data, offset, following)
        if message is not None and (message.channel_id, message.log_time) == indexed[offset]:
            messages.append(message)
    return RecoveredChunk(descriptions, messages, len(indexed))


def _indexed_messages(stream: BinaryIO, index: ChunkIndex) -> dict[int, tuple[int, int]]:
    """Return channel and time of the messages by offset, from the readable message indexes."""
    indexed: dict[int, tuple[int, int]] = {}
    for offset in index.message_index_offsets.values():
        with contextlib.suppress(*BROKEN):
            found = read_message_index(stream, offset)
            indexed |= {place: (found.channel_id, time_ns) for time_ns, place in found.records}
    return indexed


def _message_at(data: bytes, offset: int, following: int) -> Message | None:
    """Return the message at an offset; None if it is none or overlaps the following message."""
    start = offset + HEAD.size
    if start + MESSAGE_HEAD.size > following:
        return None
    opcode, length = HEAD.unpack_from(data, offset)
    if opcode != Opcode.MESSAGE or not MESSAGE_HEAD.size <= length <= following - start:
        return None
    return read_message(data, start, start + length)


_BLOCK_BYTES = 2**20
# Number of zeros at the end that are no compressed data. Disks lose data in blocks of 512 bytes.
_ZEROS = 512


class TruncatedChunk(NamedTuple):
    """Complete records at the beginning of an MCAP chunk that the end of the file cuts off.

    The checksum of the chunk cannot be compared.

    Attributes:
        compression: Compression of the chunk.
        descriptions: Schemas and channels.
        messages: Messages of known channels; at least one.
        bytes_missing: Uncompressed bytes of the chunk that are not in these records.
    """

    compression: Compression
    descriptions: list[Schema | Channel]
    messages: list[Message]
    bytes_missing: int


def read_truncated_chunk(
    stream: BinaryIO, offset: int, channels: Collection[int]
) -> TruncatedChunk | None:
    """Return the complete records of a chunk cut off by the file's end; None without any message.

    Args:
        stream: Open MCAP file; its position changes.
        offset: Offset of the chunk, which is the end of the last complete record.
        channels: IDs of the channels that are known from the records before the chunk.
    """
    with contextlib.suppress(*BROKEN):
        return _read(stream, offset, channels)
    return None


def rebuild_chunk(truncated: TruncatedChunk, offset: int) -> bytes:
    """Return the bytes of a complete MCAP chunk and its message indexes, from a truncated chunk.

    Args:
        truncated: Records of the truncated chunk.
        offset: Offset in the file at which the chunk will be written.
    """
    builder = ChunkBuilder(ChunkSettings(truncated.compression))
    for record in truncated.descriptions:
        builder.add_record(encode_record(record))
    for message in truncated.messages:
        builder.add_message(
            message.channel_id,
            message.sequence,
            message.log_time,
            message.publish_time,
            message.data,
        )
    parts, _ = builder.finish(offset)
    return b"".join(parts)


def _read(stream: BinaryIO, offset: int, channels: Collection[int]) -> TruncatedChunk | None:
    stream.seek(offset)
    opcode, length = HEAD.unpack(stream.read(HEAD.size))
    if opcode != Opcode.CHUNK:
        return None
    is_cut = offset + HEAD.size + length > os.fstat(stream.fileno()).st_size
    first_ns, last_ns, size, _ = CHUNK_HEAD.unpack(stream.read(CHUNK_HEAD.size))
    name, compressed = read_compression(stream, length)
    stored = stream.read(compressed)
    written = stored.rstrip(b"\0")
    ends_with_zeros = len(stored) - len(written) >= _ZEROS
    if not (is_cut or ends_with_zeros):
        return None
    compression = Compression(name or Compression.NONE.value)
    if compression is not Compression.NONE:
        check_unpacked(size, compressed)
    data = _beginning(compression, written if ends_with_zeros else stored, size)
    descriptions: list[Schema | Channel] = []
    messages: list[Message] = []
    known = set(channels)
    kept = 0
    # Up to the truncated record.
    with contextlib.suppress(*BROKEN):
        for opcode, start, end in iter_records(data):
            if opcode == Opcode.SCHEMA:
                descriptions.append(read_record(Schema, data[start:end]))
            elif opcode == Opcode.CHANNEL:
                channel = read_record(Channel, data[start:end])
                descriptions.append(channel)
                known.add(channel.id)
            elif opcode == Opcode.MESSAGE:
                message = read_message(data, start, end)
                if message.channel_id not in known or not first_ns <= message.log_time <= last_ns:
                    break
                messages.append(message)
            kept = end
    return TruncatedChunk(compression, descriptions, messages, size - kept) if messages else None


def _beginning(compression: Compression, data: bytes, size: int) -> bytes:
    """Return the decompressed beginning of truncated data, at most `size` bytes."""
    if compression is Compression.NONE:
        return data
    read: Callable[[int], bytes]
    if compression is Compression.ZSTD:
        import zstandard

        read = zstandard.ZstdDecompressor().stream_reader(data).read
    else:
        import lz4.frame  # type: ignore[import-untyped]  # it has no stubs

        decompressor = lz4.frame.LZ4FrameDecompressor()
        pending = [data]

        def read(most: int) -> bytes:
            unpacked: bytes = decompressor.decompress(pending.pop() if pending else b"", most)
            return unpacked

    content = bytearray()
    with contextlib.suppress(*BROKEN):
        while len(content) < size and (block := read(min(_BLOCK_BYTES, size - len(content)))):
            content += block
    return bytes(content)

"""What can be taken over from a chunk in whose middle the file ends.

After a loss of power the file may be as long as it was to be, with zeros in the place of what had
not reached the disk: it ends where these begin.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from typing import BinaryIO, NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, Message, Schema

from teleopctl.bag.mcap_file.chunk import (
    BROKEN,
    CHUNK_HEAD,
    HEAD,
    read_compression,
    read_message,
    read_record,
    records_of,
)
from teleopctl.bag.mcap_file.chunk_builder import ChunkBuilder, ChunkSettings, Compression
from teleopctl.bag.mcap_file.file_end import record_bytes
from teleopctl.bag.mcap_file.scan import Scan
from teleopctl.base.budget import check_unpacked

_BLOCK_BYTES = 2**20
# So many in turn are no end of compressed data. Disks lose what they lose in blocks of 512 bytes.
_ZEROS = 512


class CutChunk(NamedTuple):
    """The complete records at the beginning of a truncated chunk. Its checksum cannot be compared.

    Attributes:
        compression: Its own.
        descriptions: Schemas and channels.
        messages: Messages of channels that are known; never none.
        bytes_missing: How much of its uncompressed content is not in one of these records.
    """

    compression: Compression
    descriptions: list[Schema | Channel]
    messages: list[Message]
    bytes_missing: int


def read_cut_chunk(stream: BinaryIO, found: Scan) -> CutChunk | None:
    """Return the readable part of a chunk at the end of a cut file; None for nothing.

    Args:
        stream: The file; it is left somewhere.
        found: What a walk over it has found.
    """
    with contextlib.suppress(*BROKEN):
        return _read(stream, found)
    return None


def chunk_of(cut: CutChunk, offset: int) -> bytes:
    """Return a complete chunk made of a truncated one, with its message indexes.

    Args:
        cut: What there is of it.
        offset: Where in the file it is going to be.
    """
    builder = ChunkBuilder(ChunkSettings(cut.compression))
    for record in cut.descriptions:
        builder.add_record(record_bytes(record))
    for message in cut.messages:
        builder.add_message(
            message.channel_id,
            message.sequence,
            message.log_time,
            message.publish_time,
            message.data,
        )
    parts, _ = builder.take(offset)
    return b"".join(parts)


def _read(stream: BinaryIO, found: Scan) -> CutChunk | None:
    stream.seek(found.end)
    opcode, length = HEAD.unpack(stream.read(HEAD.size))
    if opcode != Opcode.CHUNK:
        return None
    is_cut = found.end + HEAD.size + length > os.fstat(stream.fileno()).st_size
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
    known = set(found.summary.channels)
    kept = 0
    # Up to the record in which it ends.
    with contextlib.suppress(*BROKEN):
        for opcode, start, end in records_of(data):
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
    return CutChunk(compression, descriptions, messages, size - kept) if messages else None


def _beginning(compression: Compression, data: bytes, size: int) -> bytes:
    """Decompress as much as there is, and not more than it should become."""
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

"""The end of a finished MCAP file: summary section and footer, read and written.

A summary with a correct checksum is trusted. The chunk indexes, of which a large file has tens of
thousands, are unpacked here: the library needs twelve reads for each.
"""

from __future__ import annotations

import io
import os
import struct
import zlib
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.summary import Summary

from teleopctl.bag.mcap_file.chunk import BROKEN, HEAD, MAGIC

_FOOTER = struct.Struct("<BQQQI")
_CHUNK_INDEX_HEAD = struct.Struct("<QQQQI")
_OFFSET = struct.Struct("<HQ")
_LENGTH = struct.Struct("<I")
_SIZES = struct.Struct("<QQ")
_INDEX_LENGTH = struct.Struct("<Q")


def read_summary(stream: BinaryIO) -> Summary | None:
    """Read and return the summary section of an MCAP file; None if it is missing or broken.

    Args:
        stream: Open MCAP file; its position changes.
    """
    try:
        return _read(stream)
    except BROKEN:
        return None


def is_complete(stream: BinaryIO) -> bool:
    """Return whether an MCAP file has its footer, and a valid summary if the footer names one.

    Args:
        stream: Open MCAP file; its position changes.
    """
    try:
        footer = _footer(stream)
    except BROKEN:
        return False
    return footer is not None and (footer.start == 0 or read_summary(stream) is not None)


class _Footer(NamedTuple):
    """Footer of a file: position and checksum of the summary, and the bytes before the checksum."""

    start: int
    end: int
    head: bytes
    checksum: int


def _footer(stream: BinaryIO) -> _Footer | None:
    size = os.fstat(stream.fileno()).st_size
    end = size - len(MAGIC) - _FOOTER.size
    if end < len(MAGIC):
        return None
    stream.seek(end)
    data = stream.read(_FOOTER.size)
    opcode, length, start, _, checksum = _FOOTER.unpack(data)
    if stream.read() != MAGIC or opcode != Opcode.FOOTER:
        return None
    if length != _FOOTER.size - HEAD.size:
        return None
    return _Footer(start, end, data[:-4], checksum)


def _read(stream: BinaryIO) -> Summary | None:
    footer = _footer(stream)
    if footer is None or not len(MAGIC) <= footer.start < footer.end:
        return None
    start = footer.start
    stream.seek(start)
    data = stream.read(footer.end - start)
    if footer.checksum and zlib.crc32(footer.head, zlib.crc32(data)) != footer.checksum:
        return None
    summary = Summary()
    offset = 0
    while offset < len(data):
        opcode, length = HEAD.unpack_from(data, offset)
        first = offset + HEAD.size
        offset = first + length
        if offset > len(data):
            return None
        _add(summary, opcode, data[first:offset])
    if any(c.chunk_start_offset + c.chunk_length > start for c in summary.chunk_indexes):
        return None
    return summary


def _add(summary: Summary, opcode: int, data: bytes) -> None:
    if opcode == Opcode.CHUNK_INDEX:
        summary.chunk_indexes.append(_chunk_index(data))
        return
    stream = ReadDataStream(io.BytesIO(data))
    if opcode == Opcode.SCHEMA:
        schema = Schema.read(stream)
        summary.schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = Channel.read(stream)
        summary.channels[channel.id] = channel
    elif opcode == Opcode.STATISTICS:
        summary.statistics = Statistics.read(stream)
    elif opcode == Opcode.ATTACHMENT_INDEX:
        summary.attachment_indexes.append(AttachmentIndex.read(stream))
    elif opcode == Opcode.METADATA_INDEX:
        summary.metadata_indexes.append(MetadataIndex.read(stream))


def _chunk_index(data: bytes) -> ChunkIndex:
    start_ns, end_ns, offset, length, offsets_length = _CHUNK_INDEX_HEAD.unpack_from(data)
    position = _CHUNK_INDEX_HEAD.size
    offsets = dict(_OFFSET.iter_unpack(data[position : position + offsets_length]))
    position += offsets_length
    (index_length,) = _INDEX_LENGTH.unpack_from(data, position)
    position += _INDEX_LENGTH.size
    (name_length,) = _LENGTH.unpack_from(data, position)
    position += _LENGTH.size
    compression = data[position : position + name_length].decode()
    compressed, uncompressed = _SIZES.unpack_from(data, position + name_length)
    return ChunkIndex(
        chunk_length=length,
        chunk_start_offset=offset,
        compression=compression,
        compressed_size=compressed,
        message_end_time=end_ns,
        message_index_length=index_length,
        message_index_offsets=offsets,
        message_start_time=start_ns,
        uncompressed_size=uncompressed,
    )


def write_end(stream: BinaryIO, start: int, summary: Summary) -> None:
    """Write data end, summary section, footer and closing magic of an MCAP file.

    Order and checksum follow the specification: the checksum covers the summary and the footer up
    to the checksum itself.

    Args:
        stream: Open file, positioned at the end of the data.
        start: Offset of that position, in bytes.
        summary: Summary with statistics.
    """
    assert summary.statistics is not None
    data_end = RecordBuilder()
    DataEnd(0).write(data_end)
    content = take_bytes(data_end)
    stream.write(content)
    start += len(content)
    groups: list[tuple[Opcode, list[McapRecord]]] = [
        (Opcode.SCHEMA, [*summary.schemas.values()]),
        (Opcode.CHANNEL, [*summary.channels.values()]),
        (Opcode.STATISTICS, [summary.statistics]),
        (Opcode.CHUNK_INDEX, [*summary.chunk_indexes]),
        (Opcode.ATTACHMENT_INDEX, [*summary.attachment_indexes]),
        (Opcode.METADATA_INDEX, [*summary.metadata_indexes]),
    ]
    builder = RecordBuilder()
    offsets = []
    for opcode, records in groups:
        group_start = builder.count
        for record in records:
            record.write(builder)
        if records:
            offsets.append(SummaryOffset(opcode, start + group_start, builder.count - group_start))
    offsets_start = start + builder.count
    for offset in offsets:
        offset.write(builder)
    content = take_bytes(builder)
    footer = RecordBuilder()
    Footer(start, offsets_start, 0).write(footer)
    checksum = zlib.crc32(take_bytes(footer)[:-4], zlib.crc32(content))
    Footer(start, offsets_start, checksum).write(footer)
    stream.write(content + take_bytes(footer) + MAGIC)


def encode_record(record: McapRecord) -> bytes:
    """Return an MCAP record as bytes."""
    builder = RecordBuilder()
    record.write(builder)
    return take_bytes(builder)


def take_bytes(builder: RecordBuilder) -> bytes:
    """Return the records that a builder holds as bytes, and clear the builder."""
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # the library's own gap
    return data

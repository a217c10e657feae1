"""The end of an MCAP file: the data's end, the summary and the footer."""

from __future__ import annotations

import zlib
from typing import BinaryIO

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer, McapRecord, SummaryOffset
from mcap.summary import Summary

from teleopctl.bag.mcap_file.chunk import MAGIC


def write_end(stream: BinaryIO, start: int, summary: Summary) -> None:
    """Write the summary section, the footer and the closing magic of a file.

    The order and the checksum are those of the specification: of the summary with the footer up to
    the checksum itself.

    Args:
        stream: The file, at the end of its data.
        start: Where that is.
        summary: With its statistics.
    """
    assert summary.statistics is not None
    data_end = RecordBuilder()
    DataEnd(0).write(data_end)
    content = taken(data_end)
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
    content = taken(builder)
    footer = RecordBuilder()
    Footer(start, offsets_start, 0).write(footer)
    checksum = zlib.crc32(taken(footer)[:-4], zlib.crc32(content))
    Footer(start, offsets_start, checksum).write(footer)
    stream.write(content + taken(footer) + MAGIC)


def record_bytes(record: McapRecord) -> bytes:
    """Return a record's bytes."""
    builder = RecordBuilder()
    record.write(builder)
    return taken(builder)


def taken(builder: RecordBuilder) -> bytes:
    """Return and clear the records that were built."""
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # the library's own gap
    return data

"""Gives an MCAP file that was never finished its end: indexes, statistics, footer."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer, McapRecord, SummaryOffset

from teleopctl.bag.mcap_file.chunk import MAGIC
from teleopctl.bag.mcap_file.lock import hold
from teleopctl.bag.mcap_file.scan import Scan, scan
from teleopctl.bag.mcap_file.summary import has_end
from teleopctl.errors import InvalidFileError, RefusedError, SystemFailureError


class Repair(NamedTuple):
    """What was done to a file.

    Attributes:
        message_count: How many messages it has.
        bytes_cut: Bytes at its end that belonged to no whole record, and are gone.
    """

    message_count: int
    bytes_cut: int


def finish_file(path: Path) -> Repair:
    """Give a file its end, in place; one that has it is left alone.

    Nothing but what stands behind the last whole record is lost.

    Raises:
        InvalidFileError: It is not an MCAP file, cannot be read, or is broken otherwise than by
            being cut off: then it is left alone.
        RefusedError: Another program is writing it.
        SystemFailureError: It cannot be written.
    """
    found = scan(path)
    statistics = found.summary.statistics
    assert statistics is not None
    try:
        with path.open("r+b") as stream:
            if not hold(stream):
                raise RefusedError(
                    f"{path} is being written by another program",
                    hint="Stop the recorder first; it ends its files itself.",
                )
            if has_end(stream):
                return Repair(statistics.message_count, 0)
            if found.gaps or not found.tail_is_cut_off:
                where = found.gaps[0][0] if found.gaps else found.end
                raise InvalidFileError(
                    f"{path} is not only cut off, but broken at byte {where}",
                    hint=f"teleopctl bag recover {path} -o FOLDER saves what can be read.",
                )
            stream.truncate(found.end)
            stream.seek(found.end)
            _write_missing_indexes(stream, found)
            _write_end(stream, found)
    except OSError as error:
        raise SystemFailureError(f"Cannot write {path}: {error.strerror}") from error
    return Repair(statistics.message_count, found.bytes_beyond)


def _write_missing_indexes(stream: BinaryIO, found: Scan) -> None:
    if not found.missing_indexes:
        return
    chunk = found.summary.chunk_indexes[-1]
    chunk.message_index_offsets = {}
    builder = RecordBuilder()
    for index in found.missing_indexes:
        chunk.message_index_offsets[index.channel_id] = found.end + builder.count
        index.write(builder)
    chunk.message_index_length = builder.count
    stream.write(_taken(builder))


def _write_end(stream: BinaryIO, found: Scan) -> None:
    """Write the data's end, the summary and the footer.

    The order and the checksum are those of the specification: of the summary with the footer up to
    the checksum itself.
    """
    data_end = RecordBuilder()
    DataEnd(0).write(data_end)
    stream.write(_taken(data_end))
    start = stream.tell()
    summary = found.summary
    assert summary.statistics is not None
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
    content = _taken(builder)
    footer = RecordBuilder()
    Footer(start, offsets_start, 0).write(footer)
    checksum = zlib.crc32(_taken(footer)[:-4], zlib.crc32(content))
    Footer(start, offsets_start, checksum).write(footer)
    stream.write(content + _taken(footer) + MAGIC)


def _taken(builder: RecordBuilder) -> bytes:
    """Take out what was built."""
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # the library's own gap
    return data

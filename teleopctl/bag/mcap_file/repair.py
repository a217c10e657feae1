"""Gives an MCAP file that was never finished its end: indexes, statistics, footer."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import RecordBuilder

from teleopctl.bag.mcap_file.file_end import taken, write_end
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
            write_end(stream, stream.tell(), found.summary)
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
    stream.write(taken(builder))

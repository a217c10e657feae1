"""Completion of an MCAP file whose writer was killed: indexes, statistics and footer."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import RecordBuilder

from teleopctl.bag.mcap_file.broken_chunks import (
    TruncatedChunk,
    read_truncated_chunk,
    rebuild_chunk,
)
from teleopctl.bag.mcap_file.file_writer import lock_file
from teleopctl.bag.mcap_file.scan import Scan, scan
from teleopctl.bag.mcap_file.summary import is_complete, take_bytes, write_end
from teleopctl.errors import InvalidFileError, RefusedError, SystemFailureError


class Repair(NamedTuple):
    """Result of `finish_file`: messages in the file, bytes cut off, and messages recovered.

    Attributes:
        message_count: Number of messages in the file.
        bytes_cut: Number of removed bytes at the end, which belonged to no complete record.
        saved_count: Number of messages recovered from a truncated chunk, whose checksum cannot be
            compared; `bytes_cut` then counts uncompressed bytes of that chunk.
    """

    message_count: int
    bytes_cut: int
    saved_count: int = 0


def finish_file(path: Path) -> Repair:
    """Complete an unfinished MCAP file in place with indexes, summary, footer; return a `Repair`.

    Only data after the last complete record is lost, also within a chunk.

    Raises:
        InvalidFileError: The file is no MCAP file, cannot be read, or is damaged, not only
            truncated; the file is not changed.
        RefusedError: Another program is writing the file.
        SystemFailureError: The file cannot be written.
    """
    found = scan(path)
    try:
        with path.open("rb") as stream:
            if is_complete(stream):
                return Repair(_message_count(found), 0)
        try:
            return _finish(path, found, saves=True)
        except OSError:
            # A full disk may have space for the end of the file without a rebuilt chunk.
            return _finish(path, found, saves=False)
    except OSError as error:
        raise SystemFailureError(f"Cannot write {path}: {error.strerror}") from error


def _finish(path: Path, found: Scan, *, saves: bool) -> Repair:
    with path.open("r+b") as stream:
        if not lock_file(stream):
            raise RefusedError(
                f"{path} is being written by another program",
                hint="Stop the recorder first; it ends its files itself.",
            )
        if is_complete(stream):  # the writer has finished it before the lock
            return Repair(_message_count(scan(path)), 0)
        if found.gaps or not found.tail_is_cut_off:
            where = found.gaps[0][0] if found.gaps else found.end
            raise InvalidFileError(
                f"{path} is not only cut off, but broken at byte {where}",
                hint=f"teleopctl bag recover {path} -o FOLDER saves what can be read.",
            )
        cut = read_truncated_chunk(stream, found.end, found.summary.channels) if saves else None
        if cut is not None:
            found = _write_chunk(stream, path, found.end, cut)
        stream.truncate(found.end)
        stream.seek(found.end)
        _write_missing_indexes(stream, found)
        write_end(stream, stream.tell(), found.summary)
    if cut is None:
        return Repair(_message_count(found), found.bytes_beyond)
    return Repair(_message_count(found), cut.bytes_missing, len(cut.messages))


def _message_count(found: Scan) -> int:
    assert found.summary.statistics is not None
    return found.summary.statistics.message_count


def _write_chunk(stream: BinaryIO, path: Path, offset: int, cut: TruncatedChunk) -> Scan:
    """Replace a truncated chunk by a complete one, and return the scan of the new file."""
    chunk = rebuild_chunk(cut, offset)
    stream.seek(offset)
    stream.write(chunk)
    stream.truncate(offset + len(chunk))
    return scan(path)


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
    stream.write(take_bytes(builder))

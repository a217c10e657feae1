"""Faults of an MCAP file: wrong checksums, and records that contradict each other."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.opcode import Opcode
from mcap.records import AttachmentIndex, ChunkIndex, MessageIndex
from mcap.summary import Summary

from teleopctl.bag.mcap_file.chunk import BROKEN, HEAD, read_message_index, rebuild_message_indexes
from teleopctl.bag.mcap_file.scan import Scan, scan
from teleopctl.bag.mcap_file.summary import is_complete, read_summary
from teleopctl.errors import InvalidFileError

_CHECKSUM = struct.Struct("<I")
_BLOCK_BYTES = 2**20
# Messages of several publishers of a topic may be recorded out of order by up to this time.
_JITTER_NS = 10_000_000


class Fault(NamedTuple):
    """Fault of a bag file: a sentence, whether finishing repairs it, whether messages may be lost.

    Attributes:
        what: Description of the fault, in one sentence.
        is_finishable: Whether completing the end of the file is the only repair needed, if any.
        loses: Whether messages may be lost by the fault.
    """

    what: str
    is_finishable: bool = False
    loses: bool = False


def mcap_file_faults(path: Path) -> Iterator[Fault]:
    """Read a whole MCAP file; yield a `Fault` for each defect that is found."""
    try:
        found = scan(path)
        with path.open("rb") as stream:
            yield from _faults_of_records(found)
            yield from _faults_of_end(stream, found)
            clock = _TimeOrder()
            for chunk in found.summary.chunk_indexes:
                # The last chunk of an unfinished file may lack message indexes only.
                is_cut = found.missing_indexes and chunk is found.summary.chunk_indexes[-1]
                fault = _fault_of_chunk(stream, chunk, clock, has_index=not is_cut)
                if fault is not None:
                    what = f"the chunk at byte {chunk.chunk_start_offset}: {fault.what}"
                    yield fault._replace(what=what)
            yield from clock.faults()
            for attachment in found.summary.attachment_indexes:
                if not _is_whole(stream, attachment):
                    yield Fault(f"the checksum of the attachment {attachment.name} is wrong")
    except InvalidFileError as error:
        yield Fault(error.message, loses=True)
    except OSError as error:
        yield Fault(f"cannot be read: {error.strerror}", loses=True)


def _faults_of_records(found: Scan) -> Iterator[Fault]:
    for start, end in found.gaps:
        yield Fault(f"{end - start} bytes from byte {start} on belong to no record", loses=True)
    for start, why in found.broken:
        yield Fault(f"the record at byte {start} is broken ({why})", loses=True)


def _faults_of_end(stream: BinaryIO, found: Scan) -> Iterator[Fault]:
    if is_complete(stream):
        fault = _fault_of_data(stream, found.end)
        if fault:
            yield Fault(fault, loses=True)
        summary = read_summary(stream)
        if summary is not None:
            yield from map(Fault, _faults_of_summary(summary, found))
    elif found.data_is_whole:
        yield Fault("its summary is missing or broken", is_finishable=True)
    else:
        rest = f"{found.bytes_beyond} bytes behind its last whole record"
        is_cut_off = found.tail_is_cut_off
        yield Fault(f"it has no end, and {rest}", is_finishable=is_cut_off, loses=not is_cut_off)


def _faults_of_summary(summary: Summary, found: Scan) -> Iterator[str]:
    """Yield the contradictions of the summary to the records; omitted parts are allowed."""
    walked = found.summary
    stated, counted = summary.statistics, walked.statistics
    if stated is not None and counted is not None:
        for what in ("message_count", "chunk_count", "attachment_count", "metadata_count"):
            if getattr(stated, what) != getattr(counted, what):
                stated_count, found_count = getattr(stated, what), getattr(counted, what)
                yield f"its summary has {stated_count} as {what}, and not {found_count}"
        if counted.message_count and (stated.message_start_time, stated.message_end_time) != (
            counted.message_start_time,
            counted.message_end_time,
        ):
            yield "its summary has other times than its messages"
    if summary.chunk_indexes and summary.chunk_indexes != walked.chunk_indexes:
        yield "the chunk indexes of its summary are not those of its chunks"
    for id_, channel in summary.channels.items():
        if walked.channels.get(id_, channel) != channel:
            yield f"its summary has another channel {id_} than its data"
    for id_, schema in summary.schemas.items():
        if walked.schemas.get(id_, schema) != schema:
            yield f"its summary has another schema {id_} than its data"


def _fault_of_data(stream: BinaryIO, end: int) -> str:
    """Return the fault of the data section's checksum, which few writers add; empty if none."""
    stream.seek(end)
    opcode, _ = HEAD.unpack(stream.read(HEAD.size))
    (stated,) = _CHECKSUM.unpack(stream.read(_CHECKSUM.size))
    if opcode != Opcode.DATA_END or not stated:
        return ""
    stream.seek(0)
    checksum, left = 0, end
    while left and (block := stream.read(min(left, _BLOCK_BYTES))):
        checksum = zlib.crc32(block, checksum)
        left -= len(block)
    return "" if checksum == stated else "the checksum of its data is wrong"


class _TimeOrder:
    """Check that the log times of each topic increase in the order of writing."""

    def __init__(self) -> None:
        self._latest: dict[int, int] = {}
        self._count = 0
        self._first_ns = 0

    def add(self, index: MessageIndex) -> None:
        """Count a channel's messages in a chunk with log times over 10 ms before earlier ones."""
        latest = self._latest.get(index.channel_id, 0)
        for time_ns, _ in sorted(index.records, key=lambda record: record[1]):
            if time_ns < latest - _JITTER_NS:
                self._first_ns = self._first_ns or latest
                self._count += 1
            latest = max(latest, time_ns)
        self._latest[index.channel_id] = latest

    def faults(self) -> Iterator[Fault]:
        """Yield one fault if any messages had earlier log times than those before them."""
        if self._count:
            yield Fault(
                f"the times of {self._count} messages are before those of earlier ones of their"
                f" topic, the first behind {self._first_ns}: the clock was set back",
                is_finishable=True,
            )


def _fault_of_chunk(
    stream: BinaryIO, chunk: ChunkIndex, clock: _TimeOrder, *, has_index: bool
) -> Fault | None:
    try:
        indexes = rebuild_message_indexes(stream, chunk)
    except BROKEN as error:
        return Fault(str(error) or type(error).__name__, loses=True)
    for index in indexes:
        clock.add(index)
    found = {index.channel_id: sorted(index.records) for index in indexes}
    times = [time_ns for records in found.values() for time_ns, _ in records]
    if times and (min(times), max(times)) != (chunk.message_start_time, chunk.message_end_time):
        return Fault("its messages have other times than it states")
    if not has_index:
        return None
    stated = {}
    try:
        for offset in chunk.message_index_offsets.values():
            index = read_message_index(stream, offset)
            if index.records:
                stated[index.channel_id] = sorted(index.records)
    except BROKEN as error:
        return Fault(f"its index cannot be read ({str(error) or type(error).__name__})")
    if chunk.message_index_offsets and stated != found:
        return Fault("its index is not that of its messages")
    return None


def _is_whole(stream: BinaryIO, index: AttachmentIndex) -> bool:
    stream.seek(index.offset + HEAD.size)
    left = index.length - HEAD.size - _CHECKSUM.size
    checksum = 0
    while left and (block := stream.read(min(left, _BLOCK_BYTES))):
        checksum = zlib.crc32(block, checksum)
        left -= len(block)
    (stated,) = _CHECKSUM.unpack(stream.read(_CHECKSUM.size))
    return stated in (0, checksum)

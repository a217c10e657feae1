"""The messages of a file without chunks, as rosbag2's preset ``fastwrite`` writes it."""

from __future__ import annotations

from array import array
from collections.abc import Collection, Iterator
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Message

from teleopctl.bag.mcap_file.chunk import HEAD, MAGIC, MESSAGE_HEAD


def loose_messages(
    stream: BinaryIO, channels: Collection[int], start_ns: int, end_ns: int
) -> Iterator[Message]:
    """Yield the messages outside of chunks by log time, up to where the file is broken.

    There is no index: the heads are read twice. What is kept at once is a number or two a message.

    Args:
        stream: The file; it is left somewhere.
        channels: Only these.
        start_ns: Only from this log time on, in nanoseconds since the epoch.
        end_ns: Only up to this log time, and not at it.
    """
    times, offsets = array("Q"), array("Q")
    is_sorted = True
    for offset, channel, log_ns in _heads(stream):
        if channel in channels and start_ns <= log_ns < end_ns:
            is_sorted = is_sorted and (not times or times[-1] <= log_ns)
            times.append(log_ns)
            offsets.append(offset)
    order = range(len(times)) if is_sorted else sorted(range(len(times)), key=times.__getitem__)
    for number in order:
        stream.seek(offsets[number])
        _, length = HEAD.unpack(stream.read(HEAD.size))
        channel, sequence, log_ns, publish_ns = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
        data = stream.read(length - MESSAGE_HEAD.size)
        yield Message(channel, log_ns, data, publish_ns, sequence)


def _heads(stream: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Where each whole message is, its channel and its log time."""
    size = stream.seek(0, 2)
    offset = len(MAGIC)
    while offset + HEAD.size <= size:
        stream.seek(offset)
        opcode, length = HEAD.unpack(stream.read(HEAD.size))
        end = offset + HEAD.size + length
        if end > size or opcode in (0, Opcode.DATA_END):
            return
        if opcode == Opcode.MESSAGE:
            if length < MESSAGE_HEAD.size:
                return
            channel, _, log_ns, _ = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
            yield offset, channel, log_ns
        offset = end

"""What can be taken over from a chunk whose checksum is wrong, though it can be decompressed."""

from __future__ import annotations

import contextlib
from typing import BinaryIO, NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Message, Schema

from teleopctl.bag.mcap_file.chunk import (
    BROKEN,
    HEAD,
    MESSAGE_HEAD,
    read_content,
    read_message,
    read_message_index,
    read_record,
    records_of,
)


class Salvaged(NamedTuple):
    """The intact records of a broken chunk.

    Attributes:
        descriptions: Schemas and channels.
        messages: Messages; their data may have changed.
        message_count: How many there were.
    """

    descriptions: list[Schema | Channel]
    messages: list[Message]
    message_count: int


def salvage_chunk(stream: BinaryIO, index: ChunkIndex) -> Salvaged:
    """Return the intact records of a broken chunk.

    Its message indexes stand behind it, and say of each message where it begins, its channel and
    its time: what agrees with them is a message, also behind a record whose length is nonsense.

    Args:
        stream: The file; it is left somewhere.
        index: Where the chunk is.

    Raises:
        Exception: One of `BROKEN`: it cannot be decompressed.
    """
    data = read_content(stream, index, checked=False)
    descriptions: list[Schema | Channel] = []
    walked: dict[int, tuple[int, int]] = {}
    # Up to where the chain of records is broken.
    with contextlib.suppress(*BROKEN):
        for opcode, start, end in records_of(data):
            if opcode == Opcode.MESSAGE:
                channel, _, log_ns, _ = MESSAGE_HEAD.unpack_from(data, start)
                walked[start - HEAD.size] = channel, log_ns
            elif opcode == Opcode.SCHEMA:
                descriptions.append(read_record(Schema, data[start:end]))
            elif opcode == Opcode.CHANNEL:
                descriptions.append(read_record(Channel, data[start:end]))
    said = _said(stream, index) or walked
    offsets = sorted(said)
    messages = []
    for offset, following in zip(offsets, [*offsets[1:], len(data)], strict=True):
        message = _message_at(data, offset, following)
        if message is not None and (message.channel_id, message.log_time) == said[offset]:
            messages.append(message)
    return Salvaged(descriptions, messages, len(said))


def _said(stream: BinaryIO, index: ChunkIndex) -> dict[int, tuple[int, int]]:
    """Channels and times of the messages by their places, as far as the indexes can be read."""
    said: dict[int, tuple[int, int]] = {}
    for offset in index.message_index_offsets.values():
        with contextlib.suppress(*BROKEN):
            found = read_message_index(stream, offset)
            said |= {place: (found.channel_id, time_ns) for time_ns, place in found.records}
    return said


def _message_at(data: bytes, offset: int, following: int) -> Message | None:
    """The message there, if it ends before the one that follows."""
    start = offset + HEAD.size
    if start + MESSAGE_HEAD.size > following:
        return None
    opcode, length = HEAD.unpack_from(data, offset)
    if opcode != Opcode.MESSAGE or not MESSAGE_HEAD.size <= length <= following - start:
        return None
    return read_message(data, start, start + length)

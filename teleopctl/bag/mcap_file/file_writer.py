"""Writes one MCAP file as rosbag2 and its viewers expect it."""

from __future__ import annotations

import contextlib
import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.summary import Summary
from mcap.well_known import Profile

from teleopctl import __version__
from teleopctl.bag.mcap_file.chunk import MAGIC
from teleopctl.bag.mcap_file.chunk_builder import ChunkBuilder, ChunkSettings
from teleopctl.bag.mcap_file.file_end import record_bytes, write_end
from teleopctl.bag.mcap_file.lock import hold
from teleopctl.bag.metadata import BagFile
from teleopctl.bag.qos_text import format_offers
from teleopctl.bag.records import COUNTED, BagAttachment, BagMessage, BagTopic
from teleopctl.errors import SystemFailureError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

LIBRARY = f"teleopctl {__version__}"
"""What the header of the files says that they were written by."""

# There are many small records around large ones.
_BUFFER_BYTES = 2**20
_SEQUENCE_MASK = 2**32 - 1


class McapFileWriter:
    """MCAP file opened for writing: profile ``ros2``, one channel per topic.

    Messages are gathered into chunks. What `flush` has written survives the death of this process,
    whatever comes after.

    Args:
        path: Where it is to be; nothing may be there.
        chunks: How its chunks are made; by default with zstd, each of 1 MiB.

    Raises:
        SystemFailureError: It cannot be made. The methods raise it where it cannot be written:
            then the file ends behind the last whole record, see `abandon`.
    """

    def __init__(self, path: Path, chunks: ChunkSettings | None = None) -> None:
        chunks = chunks or ChunkSettings()
        self.path = path
        # What the file ends with.
        self._summary = Summary()
        self._channels: dict[str, int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        self._message_counts: dict[str, int] = {}
        self._first_ns: int | None = None
        self._last_ns = 0
        try:
            self._raw = io.FileIO(path, "xb")
        except OSError as error:
            raise _failure(path, error) from error
        hold(self._raw)
        self._stream = io.BufferedWriter(self._raw, _BUFFER_BYTES)
        self._chunk_bytes = chunks.chunk_bytes
        self._chunk = ChunkBuilder(chunks)
        self._size = 0
        self._put(MAGIC, record_bytes(Header(Profile.ROS2, LIBRARY)))
        # It is an MCAP file from its first moment on.
        self._try(self._stream.flush)

    @property
    def size(self) -> int:
        """Return the bytes written so far, without the present chunk."""
        return self._size

    @property
    def is_empty(self) -> bool:
        """Return whether the file has no messages."""
        return self._first_ns is None

    @property
    def start_ns(self) -> int:
        """The earliest log time; 0 for a file without messages."""
        return self._first_ns or 0

    @property
    def message_counts(self) -> Mapping[str, int]:
        """Its messages by topic."""
        return self._message_counts

    @property
    def description(self) -> BagFile:
        """Number of messages by topic."""
        if self._first_ns is None:
            return BagFile(self.path.name)
        duration_ns = self._last_ns - self._first_ns
        count = sum(self._message_counts.values())
        return BagFile(self.path.name, self._first_ns, duration_ns, count)

    def add_topic(self, topic: BagTopic) -> None:
        """Add a channel for a topic, before its first message. Idempotent."""
        if topic.name in self._channels:
            return
        self._message_counts[topic.name] = 0
        definition = topic.definition
        schema = (topic.type_name, definition.text)
        if schema not in self._schemas:
            id_ = self._schemas[schema] = len(self._schemas) + 1
            self._summary.schemas[id_] = record = Schema(
                id_, definition.text.encode(), definition.encoding, topic.type_name
            )
            self._chunk.add_record(record_bytes(record))
        id_ = self._channels[topic.name] = len(self._channels) + 1
        self._summary.channels[id_] = channel = Channel(
            id=id_,
            topic=topic.name,
            message_encoding=topic.serialization_format,
            metadata={
                "offered_qos_profiles": format_offers(topic.qos),
                "topic_type_hash": topic.type_hash,
                **(COUNTED if topic.is_counted else {}),
            },
            schema_id=self._schemas[schema],
        )
        self._chunk.add_record(record_bytes(channel))

    def write(self, message: BagMessage) -> None:
        """Write a message of an added topic."""
        time_ns = message.log_time_ns
        if self._first_ns is None or time_ns < self._first_ns:
            self._first_ns = time_ns
        if time_ns > self._last_ns:
            self._last_ns = time_ns
        self._message_counts[message.topic] += 1
        self._chunk.add_message(
            self._channels[message.topic],
            message.sequence & _SEQUENCE_MASK,
            time_ns,
            message.publish_time_ns,
            message.data,
        )
        if self._chunk.size > self._chunk_bytes:
            self._end_chunk()

    def attach(self, attachment: BagAttachment) -> None:
        """Add an attachment."""
        name, media_type, data, log_ns = attachment
        record = record_bytes(Attachment(0, log_ns, name, media_type, data))
        self._summary.attachment_indexes.append(
            AttachmentIndex(
                offset=self._size,
                length=len(record),
                create_time=0,
                log_time=log_ns,
                data_size=len(data),
                name=name,
                media_type=media_type,
            )
        )
        self._put(record)

    def add_record(self, name: str, values: Mapping[str, str]) -> None:
        """Add a metadata record."""
        record = record_bytes(Metadata(name, dict(values)))
        self._summary.metadata_indexes.append(MetadataIndex(self._size, len(record), name))
        self._put(record)

    def flush(self) -> None:
        """Finish the present chunk and flush to the operating system."""
        self._end_chunk()
        self._try(self._stream.flush)

    def sync(self) -> None:
        """Flush the written data to the disk, and wait until that is done (fsync).

        For another thread than the one that writes: it may take seconds.
        """
        # Closed meanwhile, or on a disk that fails the next write too.
        with contextlib.suppress(OSError, ValueError):
            os.fsync(self._raw.fileno())

    def close(self) -> None:
        """Write indexes, statistics and the end, and close the file."""
        self._end_chunk()
        self._summary.statistics = self._statistics()
        self._try(lambda: write_end(self._stream, self._size, self._summary))
        self._try(self._stream.close)

    def abandon(self) -> None:
        """Close the file without a summary, after a write error."""
        # The buffer would try again to write what found no room.
        self._raw.close()

    def _end_chunk(self) -> None:
        if self._chunk.has_messages:
            parts, index = self._chunk.take(self._size)
            self._summary.chunk_indexes.append(index)
            self._put(*parts)

    def _statistics(self) -> Statistics:
        counts = {self._channels[name]: count for name, count in self._message_counts.items()}
        return Statistics(
            attachment_count=len(self._summary.attachment_indexes),
            channel_count=len(self._summary.channels),
            channel_message_counts={id_: count for id_, count in counts.items() if count},
            chunk_count=len(self._summary.chunk_indexes),
            message_count=sum(counts.values()),
            message_end_time=self._last_ns,
            message_start_time=self._first_ns or 0,
            metadata_count=len(self._summary.metadata_indexes),
            schema_count=len(self._summary.schemas),
        )

    def _put(self, *parts: bytes) -> None:
        try:
            for part in parts:
                self._stream.write(part)
                self._size += len(part)
        except OSError as error:
            raise _failure(self.path, error) from error

    def _try(self, write: Callable[[], object]) -> None:
        try:
            write()
        except OSError as error:
            raise _failure(self.path, error) from error


def _failure(path: Path, error: OSError) -> SystemFailureError:
    return SystemFailureError(f"Cannot write {path}: {error.strerror or error}")

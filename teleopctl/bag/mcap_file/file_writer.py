"""Writer of one MCAP file in the form of rosbag2, which locks the file against repair."""

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

from teleopctl.bag.base import BagFileWriter
from teleopctl.bag.mcap_file.chunk import MAGIC
from teleopctl.bag.mcap_file.chunk_builder import ChunkBuilder, ChunkSettings
from teleopctl.bag.mcap_file.summary import encode_record, write_end
from teleopctl.bag.qos_profiles import format_offered_profiles
from teleopctl.bag.records import COUNTED, BagAttachment, BagMessage, BagTopic
from teleopctl.base import __version__
from teleopctl.errors import SystemFailureError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


try:
    import fcntl
except ImportError:  # Windows, which locks files that are open for writing
    _HAS_LOCKS = False
else:
    _HAS_LOCKS = True


def lock_file(stream: io.IOBase) -> bool:
    """Lock an open file until it is closed; return False only if another program holds the lock.

    The operating system releases the lock when the program ends in any way.
    """
    if not _HAS_LOCKS:
        return True
    # Some network file systems have no locks: then the file is not locked.
    with contextlib.suppress(OSError):
        try:
            fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


LIBRARY = f"teleopctl {__version__}"
"""Name and version of the writing library in the header of the files."""

# Combines many small records into one system call.
_BUFFER_BYTES = 2**20
_SEQUENCE_MASK = 2**32 - 1


class McapFileWriter(BagFileWriter):
    """Writer of one MCAP file of a bag, with profile ``ros2`` and a channel for each topic.

    Messages are collected in chunks. Messages written before a `flush` are not lost if the process
    is killed.

    Args:
        path: Path of the file, which must not exist.
        chunks: Settings of the chunks; zstd and 1 MiB if None.

    Raises:
        SystemFailureError: The file cannot be created. The methods raise the error if writing
            fails: then the file is readable up to the last complete record, see `abandon`.
    """

    def __init__(self, path: Path, chunks: ChunkSettings | None = None) -> None:
        chunks = chunks or ChunkSettings()
        super().__init__(path)
        # Collected for the end of the file.
        self._summary = Summary()
        self._channels: dict[str, int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        try:
            self._raw = io.FileIO(path, "xb")
        except OSError as error:
            raise _failure(path, error) from error
        lock_file(self._raw)
        self._stream = io.BufferedWriter(self._raw, _BUFFER_BYTES)
        self._chunk_bytes = chunks.chunk_bytes
        self._chunk = ChunkBuilder(chunks)
        self._size = 0
        self._put(MAGIC, encode_record(Header(Profile.ROS2, LIBRARY)))
        # So that readers find a valid MCAP file at once.
        self._try(self._stream.flush)

    @property
    def size(self) -> int:
        """Number of bytes written to the file, without the current chunk."""
        return self._size

    def add_topic(self, topic: BagTopic) -> None:
        """Add a topic's schema and channel, before the topic's first message; idempotent."""
        if topic.name in self._channels:
            return
        self.message_counts[topic.name] = 0
        definition = topic.definition
        schema = (topic.type_name, definition.text)
        if schema not in self._schemas:
            id_ = self._schemas[schema] = len(self._schemas) + 1
            self._summary.schemas[id_] = record = Schema(
                id_, definition.text.encode(), definition.encoding, topic.type_name
            )
            self._chunk.add_record(encode_record(record))
        id_ = self._channels[topic.name] = len(self._channels) + 1
        self._summary.channels[id_] = channel = Channel(
            id=id_,
            topic=topic.name,
            message_encoding=topic.serialization_format,
            metadata={
                "offered_qos_profiles": format_offered_profiles(topic.qos),
                "topic_type_hash": topic.type_hash,
                **(COUNTED if topic.is_counted else {}),
            },
            schema_id=self._schemas[schema],
        )
        self._chunk.add_record(encode_record(channel))

    def write(self, message: BagMessage) -> None:
        """Add a message of an added topic to the current chunk; write the chunk if it is full."""
        self._count(message)
        self._chunk.add_message(
            self._channels[message.topic],
            message.sequence & _SEQUENCE_MASK,
            message.log_time_ns,
            message.publish_time_ns,
            message.data,
        )
        if self._chunk.size > self._chunk_bytes:
            self._end_chunk()

    def attach(self, attachment: BagAttachment) -> None:
        """Write an attachment record to the file."""
        name, media_type, data, log_ns = attachment
        record = encode_record(Attachment(0, log_ns, name, media_type, data))
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
        """Write a metadata record to the file."""
        record = encode_record(Metadata(name, dict(values)))
        self._summary.metadata_indexes.append(MetadataIndex(self._size, len(record), name))
        self._put(record)

    def flush(self) -> None:
        """Write the current chunk and all buffered data to the operating system."""
        self._end_chunk()
        self._try(self._stream.flush)

    def sync(self) -> None:
        """Wait until the data written so far is on the disk (fsync); call it from another thread.

        To be called from another thread than the one that writes, since fsync may take seconds.
        """
        # The file may be closed; an error of the disk is also raised by the next write.
        with contextlib.suppress(OSError, ValueError):
            os.fsync(self._raw.fileno())

    def close(self) -> None:
        """Write the last chunk, the summary section and the footer, and close the file."""
        self._end_chunk()
        self._summary.statistics = self._statistics()
        self._try(lambda: write_end(self._stream, self._size, self._summary))
        self._try(self._stream.close)

    def abandon(self) -> None:
        """Close the file after a write error, without a summary."""
        # Closing the buffered stream would try to write the rest again.
        self._raw.close()

    def _end_chunk(self) -> None:
        if self._chunk.has_messages:
            parts, index = self._chunk.finish(self._size)
            self._summary.chunk_indexes.append(index)
            self._put(*parts)

    def _statistics(self) -> Statistics:
        counts = {self._channels[name]: count for name, count in self.message_counts.items()}
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

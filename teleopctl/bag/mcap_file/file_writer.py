"""Writes one MCAP file as rosbag2 and its viewers expect it."""

from __future__ import annotations

import contextlib
import enum
import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

from mcap.well_known import Profile
from mcap.writer import CompressionType, Writer

from teleopctl import __version__
from teleopctl.bag.mcap_file.lock import hold
from teleopctl.bag.metadata import BagFile
from teleopctl.bag.qos_text import format_offers
from teleopctl.bag.records import COUNTED, BagAttachment, BagMessage, BagTopic
from teleopctl.errors import SystemFailureError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

LIBRARY = f"teleopctl {__version__}"
"""What the header of the files says that they were written by."""

CHUNK_BYTES = 2**20
"""How many bytes of messages are compressed and indexed together."""

# The writer of the library writes many small records around large ones.
_BUFFER_BYTES = 2**20
_SEQUENCE_MASK = 2**32 - 1


class Compression(enum.Enum):
    """How chunks are compressed: most room for ``none``, most time for ``zstd``."""

    NONE = "none"
    LZ4 = "lz4"
    ZSTD = "zstd"


_COMPRESSIONS = {
    Compression.NONE: CompressionType.NONE,
    Compression.LZ4: CompressionType.LZ4,
    Compression.ZSTD: CompressionType.ZSTD,
}


class McapFileWriter:
    """One MCAP file that is being written: profile ``ros2``, one channel a topic.

    Messages are gathered into chunks. What `flush` has written survives the death of this process,
    whatever comes after.

    Args:
        path: Where it is to be; nothing may be there.
        compression: Of the chunks.
        chunk_bytes: The size at which a chunk ends, uncompressed.

    Raises:
        SystemFailureError: It cannot be made. The methods raise it where it cannot be written:
            then the file ends behind the last whole record, see `abandon`.
    """

    def __init__(
        self,
        path: Path,
        compression: Compression = Compression.ZSTD,
        chunk_bytes: int = CHUNK_BYTES,
    ) -> None:
        self.path = path
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
        self._writer = Writer(self._stream, chunk_bytes, _COMPRESSIONS[compression])
        self._try(lambda: self._writer.start(profile=Profile.ROS2, library=LIBRARY))
        # It is an MCAP file from its first moment on.
        self._try(self._stream.flush)

    @property
    def size(self) -> int:
        """Bytes written so far, but for the chunk that has not ended yet."""
        return self._stream.tell()

    @property
    def is_empty(self) -> bool:
        """Whether it has no message."""
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
        """What ``metadata.yaml`` says of it."""
        if self._first_ns is None:
            return BagFile(self.path.name)
        duration_ns = self._last_ns - self._first_ns
        count = sum(self._message_counts.values())
        return BagFile(self.path.name, self._first_ns, duration_ns, count)

    def add_topic(self, topic: BagTopic) -> None:
        """Make a channel for a topic, before its first message. Idempotent."""
        if topic.name in self._channels:
            return
        self._message_counts[topic.name] = 0
        definition = topic.definition
        schema = (topic.type_name, definition.text)
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(
                topic.type_name, definition.encoding, definition.text.encode()
            )
        self._channels[topic.name] = self._writer.register_channel(
            topic.name,
            topic.serialization_format,
            self._schemas[schema],
            {
                "offered_qos_profiles": format_offers(topic.qos),
                "topic_type_hash": topic.type_hash,
                **(COUNTED if topic.is_counted else {}),
            },
        )

    def write(self, message: BagMessage) -> None:
        """Write a message of a topic that was added."""
        time_ns = message.log_time_ns
        if self._first_ns is None or time_ns < self._first_ns:
            self._first_ns = time_ns
        if time_ns > self._last_ns:
            self._last_ns = time_ns
        self._message_counts[message.topic] += 1
        try:
            self._writer.add_message(
                self._channels[message.topic],
                time_ns,
                message.data,
                message.publish_time_ns,
                message.sequence & _SEQUENCE_MASK,
            )
        except OSError as error:
            raise _failure(self.path, error) from error

    def attach(self, attachment: BagAttachment) -> None:
        """Add a file inside the file."""
        self._try(
            lambda: self._writer.add_attachment(
                create_time=0,
                log_time=attachment.log_time_ns,
                name=attachment.name,
                media_type=attachment.media_type,
                data=attachment.data,
            )
        )

    def add_record(self, name: str, values: Mapping[str, str]) -> None:
        """Add a record of metadata."""
        self._try(lambda: self._writer.add_metadata(name, dict(values)))

    def flush(self) -> None:
        """End the present chunk and hand all that was written over to the operating system."""
        self._try(self._writer.flush)

    def sync(self) -> None:
        """Have the operating system write to the disk what it was handed over, and wait for it.

        For another thread than the one that writes: it may take seconds.
        """
        # Closed meanwhile, or on a disk that fails the next write too.
        with contextlib.suppress(OSError, ValueError):
            os.fsync(self._raw.fileno())

    def close(self) -> None:
        """Write indexes, statistics and the end, and close the file."""
        self._try(self._writer.finish)
        self._try(self._stream.close)

    def abandon(self) -> None:
        """Close the file without an end, after it could not be written."""
        # The buffer would try again to write what found no room.
        self._raw.close()

    def _try(self, write: Callable[[], object]) -> None:
        try:
            write()
        except OSError as error:
            raise _failure(self.path, error) from error


def _failure(path: Path, error: OSError) -> SystemFailureError:
    return SystemFailureError(f"Cannot write {path}: {error.strerror or error}")

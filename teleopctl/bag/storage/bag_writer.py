"""Writing bags: a folder of files with a ``metadata.yaml`` that is kept up to date.

The files are MCAP, or SQLite databases for programs that cannot read MCAP.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from teleopctl.bag.base import BagFileWriter
from teleopctl.bag.mcap_file.chunk_builder import (
    CHUNK_BYTES,
    ChunkSettings,
    Compression,
    CompressionLevel,
)
from teleopctl.bag.mcap_file.file_writer import McapFileWriter
from teleopctl.bag.mcap_file.repair import finish_file
from teleopctl.bag.metadata import (
    MCAP,
    METADATA_FILE,
    SQLITE3,
    BagMetadata,
    format_metadata,
    write_metadata,
)
from teleopctl.bag.records import BagAttachment, BagMessage, BagTopic
from teleopctl.errors import RefusedError, SystemFailureError, TeleopctlError, UsageError

# Largest number of messages of a latched topic and publisher that a new file repeats.
_MOST_LATCHED = 100
_METADATA_PERIOD_S = 5.0
# Size of an empty database; rosbag2 also rejects smaller split sizes.
_LEAST_DATABASE_BYTES = 86_016


@dataclass(frozen=True)
class WriterOptions:
    """Options of a bag writer: storage format, compression, splitting and metadata.

    Attributes:
        compression: Compression of the chunks of MCAP files.
        chunk_bytes: Uncompressed size in bytes at which a chunk ends.
        compression_level: Level of the compression, from fastest to slowest.
        forces_compression: Whether to store a chunk compressed even if that is not smaller.
        chunk_checksums: Whether chunks have checksums, which show damage.
        database_settings: SQLite settings, as `database_settings` returns them, for a bag of
            databases; None for MCAP files, which the options above are for.
        split_bytes: Size in bytes at which a new file begins; 0 for never.
        split_duration_ns: Log time after which a new file begins, in nanoseconds; 0 for never.
        most_files: Largest number of files, beyond which the oldest is removed; 0 for no limit.
        repeat_latched: Whether each new file begins with the last messages of latched topics, so
            that the file can be played alone.
        distribution: ROS 2 distribution to write to `metadata.yaml`.
        custom_data: Keys and values of the user to write to `metadata.yaml`.

    Raises:
        UsageError: `split_bytes` is smaller than an empty database.
    """

    compression: Compression = Compression.ZSTD
    chunk_bytes: int = CHUNK_BYTES
    compression_level: CompressionLevel = CompressionLevel.DEFAULT
    forces_compression: bool = False
    chunk_checksums: bool = True
    database_settings: tuple[str, ...] | None = None
    split_bytes: int = 0
    split_duration_ns: int = 0
    most_files: int = 0
    repeat_latched: bool = True
    distribution: str = ""
    custom_data: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.storage == SQLITE3 and 0 < self.split_bytes < _LEAST_DATABASE_BYTES:
            raise UsageError(
                f"A database cannot be as small as {self.split_bytes} bytes",
                hint=f"Give {_LEAST_DATABASE_BYTES} bytes or more.",
            )

    @property
    def storage(self) -> str:
        """Storage format of the bag: ``mcap`` or ``sqlite3``."""
        return MCAP if self.database_settings is None else SQLITE3

    @property
    def chunks(self) -> ChunkSettings:
        """Settings of MCAP chunks (size, compression, checksums) among these options."""
        return ChunkSettings(
            self.compression,
            self.chunk_bytes,
            self.compression_level,
            self.forces_compression,
            self.chunk_checksums,
        )


class BagWriter:
    """Bag opened for writing: a folder of MCAP or SQLite files with ``metadata.yaml``.

    Not thread-safe. Messages written before a `flush` are not lost if the process is killed.

    Args:
        folder: Folder of the bag; it must not exist.
        options: Compression, splitting and storage format.

    Raises:
        RefusedError: The folder exists.
        SystemFailureError: The folder cannot be created. The methods raise the error if writing
            fails; the bag is then closed, and the messages written before are readable.

    Attributes:
        folder: Folder of the bag.
        message_counts: Number of written messages by topic.
        on_split: Called with the paths of the finished and the new file after a split.

    Example:
        >>> import teleopctl
        >>> teleopctl.activate()
        >>> from rclpy.serialization import serialize_message
        >>> from std_msgs.msg import String
        >>> with teleopctl.BagWriter("talk") as bag:
        ...     bag.add_topic(teleopctl.BagTopic("/chatter", "std_msgs/msg/String"))
        ...     data = serialize_message(String(data="hello"))
        ...     bag.write(teleopctl.BagMessage("/chatter", 1_000, 1_000, data))
        >>> [record.message.data for record in teleopctl.read_bag("talk")]
        ['hello']
    """

    def __init__(self, folder: Path | str, options: WriterOptions | None = None) -> None:
        self.folder = folder = Path(folder)
        self._options = options or WriterOptions()
        self.message_counts: dict[str, int] = {}
        self.on_split: Callable[[Path, Path], object] | None = None
        self._topics: dict[str, BagTopic] = {}
        self._finished: list[BagFileWriter] = []
        self._file_number = 0
        self._splits = bool(self._options.split_bytes or self._options.split_duration_ns)
        # Number of messages of each publisher to repeat, by latched topic.
        self._depths: dict[str, int] = {}
        self._latched: dict[tuple[str, bytes], deque[BagMessage]] = {}
        self._attachments: list[BagAttachment] = []
        self._records: list[tuple[str, dict[str, str]]] = []
        self._metadata_due_s = 0.0
        self._is_closed = False
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            raise RefusedError(
                f"Output folder '{folder}' already exists.",
                hint="Name another one, or remove it.",
            ) from error
        except OSError as error:
            raise SystemFailureError(f"Cannot make {folder}: {error.strerror}") from error
        self._file = self._new_file()
        self._write_metadata()

    @property
    def file(self) -> BagFileWriter:
        """Writer of the bag's current file."""
        return self._file

    @property
    def metadata(self) -> BagMetadata:
        """Metadata of the bag as written so far."""
        return BagMetadata(
            files=tuple(file.description for file in (*self._finished, self._file)),
            topics=tuple((t, self.message_counts[t.name]) for t in self._topics.values()),
            storage=self._options.storage,
            distribution=self._options.distribution,
            custom_data=self._options.custom_data,
        )

    def add_topic(self, topic: BagTopic) -> None:
        """Add a topic to this and all following files, before its first message; idempotent."""
        if topic.name not in self._topics:
            self._topics[topic.name] = topic
            self.message_counts[topic.name] = 0
            if topic.is_latched and self._options.repeat_latched:
                depth = max(profile.depth for profile in topic.qos)
                self._depths[topic.name] = min(depth or 1, _MOST_LATCHED)
            self._attempt(lambda: self._file.add_topic(topic))

    def write(self, message: BagMessage) -> None:
        """Write a message of an added topic; start a new file if the present one is full."""
        if self._splits and self._is_time_to_split(message):
            self.split(message.log_time_ns)
        try:
            self._file.write(message)
        except SystemFailureError:
            self._close_open_files()
            raise
        self.message_counts[message.topic] += 1
        if message.topic in self._depths:
            self._remember(message)

    def attach(self, attachment: BagAttachment) -> None:
        """Add an attachment to the present and all following files."""
        self._attachments.append(attachment)
        self._attempt(lambda: self._file.attach(attachment))

    def add_record(self, name: str, values: Mapping[str, str]) -> None:
        """Add a metadata record to the present and all following files."""
        self._records.append((name, dict(values)))
        self._attempt(lambda: self._file.add_record(name, values))

    def split(self, time_ns: int | None = None) -> tuple[Path, Path]:
        """Finish the present file and start a new one; return the paths of both, in this order.

        Args:
            time_ns: Log time of the repeated messages; None for that of the last message.
        """
        ended = self._file
        self._attempt(lambda: self._finish(ended))
        self._finished.append(ended)
        self._file = self._new_file()
        if time_ns is None:
            time_ns = ended.description.end_ns
        for message in itertools.chain.from_iterable(self._latched.values()):
            repeated = message._replace(log_time_ns=time_ns, sequence=0)
            self._attempt(functools.partial(self._file.write, repeated))
            self.message_counts[message.topic] += 1
        self._remove_oldest()
        self._write_metadata()
        if self.on_split is not None:
            self.on_split(ended.path, self._file.path)
        return ended.path, self._file.path

    def flush(self) -> None:
        """Write buffered messages to the operating system; rewrite ``metadata.yaml`` every 5 s."""
        self._attempt(self._file.flush)
        if time.monotonic() >= self._metadata_due_s:
            self._write_metadata()

    def close(self) -> None:
        """Finish the present file and ``metadata.yaml``; idempotent."""
        if not self._is_closed:
            self._attempt(lambda: self._finish(self._file))
            self._is_closed = True
            self._write_metadata()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _new_file(self) -> BagFileWriter:
        stem = f"{self.folder.name}_{self._file_number}"
        self._file_number += 1
        file: BagFileWriter
        if self._options.database_settings is None:
            file = McapFileWriter(self.folder / f"{stem}.mcap", self._options.chunks)
        else:
            from teleopctl.bag.storage.sqlite_writer import SqliteFileWriter

            settings = self._options.database_settings
            path = self.folder / f"{stem}.db3"
            file = SqliteFileWriter(path, settings, self._options.distribution)
        for topic in self._topics.values():
            file.add_topic(topic)
        for attachment in self._attachments:
            file.attach(attachment)
        for name, values in self._records:
            file.add_record(name, values)
        return file

    def _remove_oldest(self) -> None:
        most = self._options.most_files
        while most and len(self._finished) >= most:
            oldest = self._finished.pop(0)
            for topic, count in oldest.message_counts.items():
                self.message_counts[topic] -= count
            # Another program may have removed or opened the file.
            with contextlib.suppress(OSError):
                oldest.path.unlink()

    def _finish(self, file: BagFileWriter) -> None:
        # rosbag2 reads this record if metadata.yaml is missing.
        text = format_metadata(self.metadata, with_root=False)
        file.add_record("rosbag2", {"serialized_metadata": text})
        file.close()

    def _is_time_to_split(self, message: BagMessage) -> bool:
        options, file = self._options, self._file
        if file.is_empty:
            return False
        if options.split_bytes and file.size >= options.split_bytes:
            return True
        age_ns = message.log_time_ns - file.start_ns
        return bool(options.split_duration_ns) and age_ns >= options.split_duration_ns

    def _remember(self, message: BagMessage) -> None:
        key = (message.topic, message.publisher)
        if key not in self._latched:
            self._latched[key] = deque(maxlen=self._depths[message.topic])
        self._latched[key].append(message)

    def _attempt(self, write: Callable[[], object]) -> None:
        """Call a function that writes; if it fails, close the file so that it stays readable."""
        try:
            write()
        except SystemFailureError:
            self._close_open_files()
            raise

    def _close_open_files(self) -> None:
        self._is_closed = True
        self._file.abandon()
        # Removing the incomplete last record may free the space that the end of the file needs.
        if isinstance(self._file, McapFileWriter):
            with contextlib.suppress(TeleopctlError):
                finish_file(self._file.path)
        with contextlib.suppress(SystemFailureError):
            self._write_metadata()

    def _write_metadata(self) -> None:
        write_metadata(self.folder / METADATA_FILE, self.metadata)
        self._metadata_due_s = time.monotonic() + _METADATA_PERIOD_S

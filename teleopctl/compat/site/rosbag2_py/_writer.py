"""``rosbag2_py._writer``. Writing of bags, message by message."""

import dataclasses
import weakref
from pathlib import Path
from types import TracebackType
from typing import Self

from rosbag2_py._compression_options import CompressionMode, CompressionOptions
from rosbag2_py._storage import (
    STORAGES,
    ConverterOptions,
    StorageOptions,
    TopicMetadata,
    errors_of_rosbag2,
    topic_of,
)
from teleopctl import bag
from teleopctl.interfaces import distribution

__all__ = [
    "SequentialCompressionWriter",
    "SequentialWriter",
    "get_registered_compressors",
    "get_registered_serializers",
    "get_registered_writers",
    "writer_options",
]


def writer_options(options: StorageOptions, *, compressed: bool = False) -> bag.WriterOptions:
    """Return the options of a bag's files.

    Raises:
        RuntimeError: A preset or a configuration file is invalid, or compression is not possible.
    """
    preset = options.storage_preset_profile
    config = Path(options.storage_config_uri) if options.storage_config_uri else None
    with errors_of_rosbag2():
        if options.storage_id == "sqlite3":
            if compressed:
                raise RuntimeError("SQLite bags cannot be compressed here; mcap can")
            chosen = bag.WriterOptions(database_settings=bag.database_settings(preset, config))
        else:
            chunks = bag.chunk_settings(preset, config)
            if compressed:
                chunks = chunks._replace(compression=bag.Compression.ZSTD)
            chosen = bag.WriterOptions(**chunks._asdict())
        return dataclasses.replace(
            chosen,
            split_bytes=options.max_bagfile_size,
            split_duration_ns=options.max_bagfile_duration * 10**9,
            distribution=distribution(),
            custom_data=dict(options.custom_data),
        )


class SequentialWriter:
    """Writer of a bag.

    The bag is closed by `close`, with the writer itself, and at the end of the program.

    Example:
        >>> writer = SequentialWriter()
        >>> writer.open(StorageOptions(uri="session"), ConverterOptions())
        >>> writer.create_topic(TopicMetadata(0, "/chatter", "std_msgs/msg/String", "cdr"))
        >>> writer.write("/chatter", serialize_message(String(data="hello")), 1_000)
    """

    def __init__(self) -> None:
        self._writer: bag.BagWriter | None = None
        self._names: set[str] = set()
        self._finish: weakref.finalize[..., SequentialWriter] | None = None
        self._compressed = False

    def open(
        self,
        storage_options: StorageOptions,
        converter_options: ConverterOptions | None = None,  # noqa: ARG002 -- checked when made
    ) -> None:
        """Create a bag.

        Raises:
            RuntimeError: The folder exists or cannot be created, or an option is not possible.
        """
        self.close()
        if storage_options.snapshot_mode:
            raise RuntimeError("snapshots are taken by a Recorder, not by a writer")
        options = writer_options(storage_options, compressed=self._compressed)
        with errors_of_rosbag2():
            self._writer = bag.BagWriter(storage_options.uri, options)
        self._finish = weakref.finalize(self, self._writer.close)

    def close(self) -> None:
        """Finish the bag. Idempotent."""
        if self._finish is not None:
            with errors_of_rosbag2():
                self._finish()
        self._writer = self._finish = None
        self._names.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.close()

    def create_topic(self, topic: TopicMetadata) -> None:
        """Add a topic, before its first message.

        Raises:
            RuntimeError: No bag is open, or the serialization format is not ``cdr``.
        """
        if topic.serialization_format not in ("", "cdr"):
            raise RuntimeError(
                f"topic '{topic.name}': messages in '{topic.serialization_format}' cannot be "
                "written, only in cdr"
            )
        with errors_of_rosbag2():
            self._opened().add_topic(topic_of(topic))
        self._names.add(topic.name)

    def remove_topic(self, topic: TopicMetadata) -> None:
        """End a topic: no further messages can be written to it.

        Raises:
            RuntimeError: The topic was not created.
        """
        if topic.name not in self._names:
            raise RuntimeError(f"Failed to remove the non-existing topic '{topic.name}'!")
        self._names.remove(topic.name)

    def write(
        self, topic_name: str, message: bytes, time_stamp: int, send_time_stamp: int | None = None
    ) -> None:
        """Write a message.

        Args:
            topic_name: Name of a topic of `create_topic`.
            message: Serialized message.
            time_stamp: Time of receipt in nanoseconds.
            send_time_stamp: Time of publication in nanoseconds; that of receipt if None.

        Raises:
            RuntimeError: No bag is open, the topic was not created, or writing fails.
        """
        writer = self._opened()
        if topic_name not in self._names:
            raise RuntimeError(
                f"Topic '{topic_name}' has not been created yet! Call 'create_topic' first."
            )
        sent = time_stamp if send_time_stamp is None else send_time_stamp
        with errors_of_rosbag2():
            writer.write(bag.BagMessage(topic_name, time_stamp, sent, bytes(message)))

    def split_bagfile(self) -> None:
        """Begin a new file of the bag."""
        with errors_of_rosbag2():
            self._opened().split()

    def take_snapshot(self) -> bool:
        """Return False: a writer has no snapshot; a `Recorder` has."""
        return False

    def _opened(self) -> bag.BagWriter:
        if self._writer is None:
            raise RuntimeError("Bag is not open. Call open() before writing.")
        return self._writer


class SequentialCompressionWriter(SequentialWriter):
    """Writer of a bag whose chunks are compressed with zstd."""

    def __init__(self, compression_options: CompressionOptions | None = None) -> None:
        super().__init__()
        options = compression_options or CompressionOptions()
        if options.compression_format not in ("", "zstd"):
            raise RuntimeError(f"compression format '{options.compression_format}' is unknown")
        self._compressed = options.compression_mode is not CompressionMode.NONE


def get_registered_writers() -> set[str]:
    """Return the storage formats that can be written."""
    return set(STORAGES)


def get_registered_compressors() -> set[str]:
    """Return the formats of compression."""
    return {"zstd"}


def get_registered_serializers() -> set[str]:
    """Return the serialization formats that messages can have."""
    return {"cdr"}

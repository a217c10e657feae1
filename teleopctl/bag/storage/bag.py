"""A bag that is read, whoever wrote it: rosbag2's folders and files, and ROS 1's bags."""

from __future__ import annotations

import contextlib
import heapq
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Protocol, Self

from teleopctl.bag.mcap_file.file_reader import McapFileReader
from teleopctl.bag.metadata import (
    MCAP,
    METADATA_FILE,
    BagFile,
    BagMetadata,
    parse_metadata,
    read_metadata,
)
from teleopctl.bag.records import NO_TIME_NS, BagAttachment, BagMessage, BagTopic
from teleopctl.errors import InvalidFileError, NotFoundError


class Bag(Protocol):
    """A bag that is open for reading.

    Attributes:
        path: The folder or file.
        metadata: What it holds.
        remarks: What is not as it should be, one sentence each, such as an unfinished file.
    """

    path: Path
    metadata: BagMetadata
    remarks: list[str]

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages in the order of their log times.

        Args:
            topics: Only these; all if None.
            start_ns: Only from this log time on, in nanoseconds since the epoch.
            end_ns: Only up to this log time, and not at it.
            left_out: Called with a sentence for each part of an MCAP file that is broken; its
                messages are missing then.

        Raises:
            InvalidFileError: A part of it is broken, and nobody is to be told; the message says
                where.
        """

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return the last messages of a topic before a log time, oldest first.

        Args:
            topic: Its full name.
            end_ns: The log time, in nanoseconds since the epoch.
            most: How many.
        """

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield the files inside it."""

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield the names and values of its records of metadata."""

    def close(self) -> None:
        """Close its files."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


def open_bag(path: Path, storage: str | None = None) -> Bag:
    """Open a bag.

    A folder without ``metadata.yaml`` is read too, and so is a file that was never finished.

    Args:
        path: The folder, or one of its files.
        storage: ``mcap`` or ``sqlite3``, where the path does not tell.

    Raises:
        NotFoundError: Nothing is there, or no bag.
        InvalidFileError: It cannot be read.
    """
    if not path.exists():
        raise NotFoundError(f"Bag path '{path}' does not exist!")
    files = bag_files(path)
    if not files:
        raise NotFoundError(
            f"'{path}' is no bag: it has neither {METADATA_FILE} nor a file of a bag",
            hint="A bag is a folder with .mcap or .db3 files, one such file, or a .bag of ROS 1.",
        )
    metadata, remark = _metadata(path, files)
    is_plain = metadata is None or not metadata.compression_mode
    if is_plain and (storage == MCAP or all(file.suffix == ".mcap" for file in files)):
        bag = open_files(path, files, metadata)
        bag.remarks += remark
        return bag
    from teleopctl.bag.storage.foreign import ForeignBag

    return ForeignBag(path, metadata)


def open_files(path: Path, files: list[Path], metadata: BagMetadata | None) -> Bag:
    """Open MCAP files as one bag.

    Args:
        path: What the bag is called.
        files: The files.
        metadata: What ``metadata.yaml`` says, which the files complete and correct.

    Raises:
        InvalidFileError: None of them can be read.
    """
    return _McapBag(path, files, metadata)


def _metadata(path: Path, files: list[Path]) -> tuple[BagMetadata | None, list[str]]:
    """What ``metadata.yaml`` says; a remark in its place where MCAP files can do without it."""
    if not (path / METADATA_FILE).is_file():
        return None, []
    try:
        return read_metadata(path), []
    except InvalidFileError as error:
        if any(file.suffix != ".mcap" for file in files):
            raise
        return None, [f"{error.message}; the files tell what is in them"]


def bag_files(path: Path) -> list[Path]:
    """The files of a bag in the order in which they were written.

    Those that ``metadata.yaml`` names, and what a recorder that was killed could no longer add.

    """
    if path.is_file():
        return [path]
    named = []
    if (path / METADATA_FILE).is_file():
        with contextlib.suppress(InvalidFileError):
            named = [path / file.path for file in read_metadata(path).files]
    known = {file.name for file in named}
    others = [f for f in path.iterdir() if f.suffix in (".mcap", ".db3") and f.name not in known]
    return [*named, *sorted(others, key=by_number)]


def by_number(file: Path) -> tuple[int, str]:
    """What to sort files by: ``x_10.mcap`` comes behind ``x_9.mcap``."""
    number = file.stem.rpartition("_")[2]
    return (int(number) if number.isascii() and number.isdigit() else -1, file.name)


class _McapBag:
    """A bag of MCAP files; see `Bag`."""

    def __init__(self, path: Path, files: list[Path], metadata: BagMetadata | None) -> None:
        self.path = path
        self.remarks: list[str] = []
        self._readers: list[McapFileReader] = []
        try:
            for file in files:
                self._open(file, alone=len(files) == 1)
        except BaseException:
            self.close()
            raise
        metadata = metadata or self._kept_metadata()
        # The files know best: metadata.yaml may be older than they are.
        self.metadata = BagMetadata(
            files=tuple(reader.description for reader in self._readers),
            topics=tuple(self._topics(metadata or BagMetadata()).values()),
            custom_data=metadata.custom_data if metadata else {},
            distribution=metadata.distribution if metadata else "",
        )

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        readers = sorted(self._readers, key=lambda reader: reader.description.start_ns)
        for group in _overlapping(readers):
            yield from heapq.merge(
                *(reader.messages(topics, start_ns, end_ns, left_out) for reader in group),
                key=lambda message: message.log_time_ns,
            )

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        found: list[BagMessage] = []
        readers = [reader for reader in self._readers if reader.description.message_count]
        for reader in sorted(readers, key=lambda r: r.description.end_ns, reverse=True):
            if len(found) >= most and reader.description.end_ns < found[0].log_time_ns:
                break
            found += reader.latest(topic, end_ns, most)
            found = sorted(found, key=lambda message: message.log_time_ns)[-most:]
        return found

    def attachments(self) -> Iterator[BagAttachment]:
        seen = set()
        for reader in self._readers:
            for attachment in reader.attachments():
                # Each file of a bag repeats those of the ones before it.
                if attachment not in seen:
                    seen.add(attachment)
                    yield attachment

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        seen = []
        for reader in self._readers:
            for record in reader.records():
                if record not in seen:
                    seen.append(record)
                    yield record

    def close(self) -> None:
        for reader in self._readers:
            reader.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _open(self, file: Path, *, alone: bool) -> None:
        try:
            reader = McapFileReader(file)
        except InvalidFileError as error:
            if alone:
                raise
            self.remarks.append(f"{error.message}; it is left out")
            return
        self._readers.append(reader)
        self.remarks += reader.remarks
        if not reader.is_finished:
            self.remarks.append(
                f"{file} was not finished: it is read as far as it is whole"
                f" (teleopctl bag recover {self.path} gives it its end)"
            )

    def _kept_metadata(self) -> BagMetadata | None:
        """What the last finished file has of ``metadata.yaml``, which rosbag2 puts into each."""
        for reader in reversed(self._readers):
            for name, values in reader.records():
                with contextlib.suppress(InvalidFileError):
                    if name == "rosbag2":
                        text = values.get("serialized_metadata", "")
                        return parse_metadata(text, with_root=False)
        return None

    def _topics(self, metadata: BagMetadata) -> dict[str, tuple[BagTopic, int]]:
        # Not every writer puts hash and profiles into the channel.
        described = {topic.name: topic for topic, _ in metadata.topics}
        topics: dict[str, tuple[BagTopic, int]] = {}
        for reader in self._readers:
            for name, (topic, count) in reader.topics.items():
                known, before = topics.get(name, (described.get(name, topic), 0))
                merged = topic._replace(
                    type_hash=topic.type_hash or known.type_hash,
                    qos=tuple(dict.fromkeys((*known.qos, *topic.qos))),
                    is_counted=topic.is_counted and (name not in topics or known.is_counted),
                )
                topics[name] = (merged, before + count)
        return topics


def _overlapping(readers: list[McapFileReader]) -> Iterator[list[McapFileReader]]:
    """Group files, sorted by their start, whose times overlap: only those have to be merged."""
    group: list[McapFileReader] = []
    end_ns = 0
    for reader in readers:
        file: BagFile = reader.description
        if not file.message_count:
            continue
        if group and file.start_ns > end_ns:
            yield group
            group = []
        group.append(reader)
        end_ns = max(end_ns, file.end_ns)
    if group:
        yield group

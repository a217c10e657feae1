"""Opening bags for reading: rosbag2's folders and single files, and ROS 1 bags."""

from __future__ import annotations

import contextlib
import heapq
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import gettempdir

from teleopctl.bag.base import Bag, BagFileReader
from teleopctl.bag.mcap_file.file_reader import ChunkRecovery, McapFileReader
from teleopctl.bag.metadata import (
    MCAP,
    METADATA_FILE,
    SQLITE3,
    BagFile,
    BagMetadata,
    parse_metadata,
    read_metadata,
)
from teleopctl.bag.records import NO_TIME_NS, BagAttachment, BagMessage, BagTopic
from teleopctl.bag.storage.compression import (
    SUFFIX,
    ZSTD,
    require_zstd,
    unpack_file,
    unpack_messages,
)
from teleopctl.base.files import missing_content
from teleopctl.base.temporary import TemporaryFolder
from teleopctl.errors import InvalidFileError, NotFoundError

_SUFFIXES = (".mcap", ".db3")
_SUFFIX_OF_STORAGE = {MCAP: ".mcap", SQLITE3: ".db3"}
_SQLITE_MAGIC = b"SQLite format 3\0"


def open_bag(
    path: Path | str, storage: str | None = None, recovery: ChunkRecovery | None = None
) -> Bag:
    """Open a bag for reading: a folder or file of rosbag2 (MCAP, SQLite), or a bag of ROS 1.

    A folder without ``metadata.yaml`` and an unfinished file can be read as well.

    Args:
        path: Folder of the bag, or one of its files.
        storage: ``mcap`` or ``sqlite3``, if the path does not show it.
        recovery: Filter and callback for messages of broken chunks of MCAP files; None drops them.

    Raises:
        NotFoundError: The path does not exist or is no bag.
        InvalidFileError: The bag cannot be read.
        UnsupportedError: The compression of the bag is unknown.

    Example:
        >>> with open_bag("session") as bag:
        ...     print(bag.metadata.message_count, bag.remarks)
        3 []
    """
    path = Path(path)
    if not path.exists():
        raise NotFoundError(f"Bag path '{path}' does not exist!")
    files = bag_files(path)
    if not files:
        raise NotFoundError(
            f"'{path}' is not a bag: it has neither {METADATA_FILE} nor a file of a bag",
            hint="A bag is a folder with .mcap or .db3 files, one such file, or a .bag of ROS 1.",
        )
    if files[0].suffix == ".bag":
        from teleopctl.bag.storage.ros1_bag import Ros1Bag

        return Ros1Bag(files[0])
    metadata, remark = _metadata(path)
    bag = open_files(path, files, metadata, storage, recovery)
    bag.remarks += remark
    return bag


def open_files(
    path: Path,
    files: list[Path],
    metadata: BagMetadata | None,
    storage: str | None = None,
    recovery: ChunkRecovery | None = None,
) -> Bag:
    """Open given MCAP files or SQLite databases for reading as one bag.

    Args:
        path: Path of the bag, as shown in messages.
        files: Paths of the files.
        metadata: Content of ``metadata.yaml``, which the files complete and correct; None without.
        storage: As for `open_bag`.
        recovery: As for `open_bag`.

    Raises:
        InvalidFileError: The only file cannot be read.
        UnsupportedError: The compression of the bag is unknown.
    """
    return _FilesBag(path, files, metadata, storage, recovery)


def _metadata(path: Path) -> tuple[BagMetadata | None, list[str]]:
    """Return the content of ``metadata.yaml``, or None with a remark if the file is invalid."""
    if not (path / METADATA_FILE).is_file():
        return None, []
    try:
        return read_metadata(path), []
    except InvalidFileError as error:
        return None, [f"{error.message}; the content is taken from the files"]


def bag_files(path: Path) -> list[Path]:
    """Return a bag's files in the order of writing: those in ``metadata.yaml``, then others.

    The other files are those that a killed recorder did not add to ``metadata.yaml``.
    """
    if path.is_file():
        return [path]
    named = []
    if (path / METADATA_FILE).is_file():
        with contextlib.suppress(InvalidFileError):
            named = [path / file.path for file in read_metadata(path).files]
    known = {file.name for file in named}
    return [*named, *(file for file in stored_files(path) if file.name not in known)]


def stored_files(folder: Path) -> list[Path]:
    """Return the bag files in a folder, sorted by number, whatever ``metadata.yaml`` lists."""
    found = {file for file in folder.iterdir() if _suffix(file) in _SUFFIXES}
    # A file that was decompressed by hand may be next to its compressed original.
    return sorted(
        (f for f in found if f.suffix != SUFFIX or f.with_suffix("") not in found), key=_by_number
    )


def _by_number(file: Path) -> tuple[int, str]:
    """Return the sort key of a file, with which ``x_10.mcap`` is after ``x_9.mcap``."""
    number = file.name.partition(".")[0].rpartition("_")[2]
    return (int(number) if number.isascii() and number.isdigit() else -1, file.name)


def _suffix(file: Path) -> str:
    """Return the last suffix of a file's name, without that of a compression."""
    return Path(file.name.removesuffix(SUFFIX)).suffix


def _open_file(file: Path, storage: str | None, recovery: ChunkRecovery | None) -> BagFileReader:
    suffix = file.suffix
    if suffix not in _SUFFIXES:
        suffix = _SUFFIX_OF_STORAGE.get(storage or "", "")
    if suffix == ".db3" or (not suffix and _begins_with(file, _SQLITE_MAGIC)):
        from teleopctl.bag.storage.sqlite_reader import SqliteFileReader

        return SqliteFileReader(file)
    return McapFileReader(file, recovery)


def _absence(file: Path) -> str:
    try:
        return missing_content(file)
    except OSError:
        return ""  # the reader of the file reports the error


def _begins_with(file: Path, magic: bytes) -> bool:
    with contextlib.suppress(OSError), file.open("rb") as stream:
        return stream.read(len(magic)) == magic
    return False


class _FilesBag(Bag):
    """Bag of MCAP files or SQLite databases."""

    def __init__(
        self,
        path: Path,
        files: list[Path],
        metadata: BagMetadata | None,
        storage: str | None,
        recovery: ChunkRecovery | None,
    ) -> None:
        self.path = path
        self._recovery = recovery
        self.remarks: list[str] = []
        self._readers: list[BagFileReader] = []
        self._descriptions: list[BagFile] = []
        self._unpacked: TemporaryFolder | None = None
        self._has_packed_messages = metadata is not None and metadata.compression_mode == "message"
        if metadata is not None and metadata.compression_mode:
            require_zstd(metadata.compression_format)
        try:
            for file in files:
                self._open(file, storage, alone=len(files) == 1)
        except BaseException:
            self.close()
            raise
        metadata = metadata or self._kept_metadata() or BagMetadata()
        distributions = (reader.distribution for reader in self._readers)
        # The files take precedence: metadata.yaml may be older.
        self.metadata = BagMetadata(
            files=tuple(self._descriptions),
            topics=tuple(self._topics(metadata).values()),
            storage=self._readers[0].STORAGE if self._readers else metadata.storage,
            compression_format=metadata.compression_format or (ZSTD if self._unpacked else ""),
            compression_mode=metadata.compression_mode or ("file" if self._unpacked else ""),
            custom_data=metadata.custom_data,
            distribution=metadata.distribution or next(filter(None, distributions), ""),
        )

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        readers = sorted(self._readers, key=lambda reader: reader.description.start_ns)
        for group in _overlapping(readers):
            found: Iterator[BagMessage] = heapq.merge(
                *(reader.messages(topics, start_ns, end_ns, on_left_out) for reader in group),
                key=lambda message: message.log_time_ns,
            )
            if self._has_packed_messages:
                found = unpack_messages(found, self.path, on_left_out)
            yield from found

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        found: list[BagMessage] = []
        readers = [reader for reader in self._readers if reader.description.message_count]
        for reader in sorted(readers, key=lambda r: r.description.end_ns, reverse=True):
            if len(found) >= most and reader.description.end_ns < found[0].log_time_ns:
                break
            found += reader.latest(topic, end_ns, most)
            found = sorted(found, key=lambda message: message.log_time_ns)[-most:]
        if self._has_packed_messages:
            found = list(unpack_messages(iter(found), self.path, lambda _: None))
        return found

    def attachments(self) -> Iterator[BagAttachment]:
        seen = set()
        for reader in self._readers:
            for attachment in reader.attachments():
                # Each file of a bag repeats the attachments of the previous files.
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
        if self._unpacked is not None:
            self._unpacked.remove()

    def _open(self, file: Path, storage: str | None, *, alone: bool) -> None:
        try:
            if why := _absence(file):
                raise InvalidFileError(f"{file} {why}")
            reader = _open_file(self._plain(file), storage, self._recovery)
        except InvalidFileError as error:
            if alone:
                raise
            self.remarks.append(f"{error.message}; it is left out")
            return
        self._readers.append(reader)
        self._descriptions.append(replace(reader.description, path=file.name))
        self.remarks += reader.remarks
        if not reader.is_finished:
            self.remarks.append(
                f"{file} was not finished, or is damaged: it is read as far as it is intact"
                f" (teleopctl bag recover {self.path} repairs it)"
            )

    def _plain(self, file: Path) -> Path:
        """Return the path of a file, or of its decompressed copy if the file is compressed."""
        if file.suffix != SUFFIX:
            return file
        self._unpacked = self._unpacked or TemporaryFolder(Path(gettempdir()))
        plain, fault = unpack_file(file, self._unpacked.path)
        if fault:
            self.remarks.append(fault)
        return plain

    def _kept_metadata(self) -> BagMetadata | None:
        """Return the metadata in the last finished file, which rosbag2 writes to each, or None."""
        for reader in reversed(self._readers):
            for name, values in reader.records():
                with contextlib.suppress(InvalidFileError):
                    if name == "rosbag2":
                        text = values.get("serialized_metadata", "")
                        return parse_metadata(text, with_root=False)
        return None

    def _topics(self, metadata: BagMetadata) -> dict[str, tuple[BagTopic, int]]:
        # Not every writer adds hash and QoS profiles to the channel.
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


def _overlapping(
    readers: list[BagFileReader],
) -> Iterator[list[BagFileReader]]:
    """Group files, sorted by their start, whose times overlap: only those have to be merged."""
    group: list[BagFileReader] = []
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

"""Checks of a bag: files, metadata, type definitions, messages and sequence numbers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import gettempdir
from typing import Any, NamedTuple

from teleopctl.bag.base import Bag
from teleopctl.bag.editing.copying import ProgressCallback
from teleopctl.bag.mcap_file.inspection import Fault, mcap_file_faults
from teleopctl.bag.metadata import METADATA_FILE, BagMetadata, read_metadata
from teleopctl.bag.records import CDR, ROS2MSG, BagMessage, BagTopic
from teleopctl.bag.storage.bag import bag_files, open_bag
from teleopctl.bag.storage.compression import SUFFIX, unpack_file
from teleopctl.bag.type_definitions import topic_message_class
from teleopctl.base.temporary import TemporaryFolder
from teleopctl.errors import InvalidFileError, TeleopctlError
from teleopctl.interfaces import deserialize, hash_of_text


def metadata_differences(stated: BagMetadata, found: BagMetadata) -> Iterator[str]:
    """Yield a sentence for each difference between ``metadata.yaml`` and the metadata of the files.

    Args:
        stated: Metadata in ``metadata.yaml``.
        found: Metadata computed from the files.
    """
    stated_files = {file.path: file for file in stated.files}
    found_files = {file.path: file for file in found.files}
    for path in stated_files.keys() - found_files.keys():
        yield f"{path} is listed, and does not exist or cannot be read"
    for path in found_files.keys() - stated_files.keys():
        yield f"{path} is not listed"
    for path in sorted(stated_files.keys() & found_files.keys()):
        yield from _differences(
            path,
            ("message count", stated_files[path].message_count, found_files[path].message_count),
            ("start in ns", stated_files[path].start_ns, found_files[path].start_ns),
            ("duration in ns", stated_files[path].duration_ns, found_files[path].duration_ns),
        )
    stated_topics = {topic.name: (topic, count) for topic, count in stated.topics}
    found_topics = {topic.name: (topic, count) for topic, count in found.topics}
    for name in sorted(stated_topics.keys() ^ found_topics.keys()):
        where = "the files" if name in found_topics else "metadata.yaml"
        yield f"only {where} have {name}" if name in found_topics else f"only {where} has {name}"
    for name in sorted(stated_topics.keys() & found_topics.keys()):
        (stated_topic, stated_count), (found_topic, count) = stated_topics[name], found_topics[name]
        yield from _differences(name, ("message count", stated_count, count))
        if stated_topic.type_name != found_topic.type_name:
            yield (
                f"{name}: type is {stated_topic.type_name} in metadata.yaml"
                f" and {found_topic.type_name} in the files"
            )


def _differences(name: str, *pairs: tuple[str, int, int]) -> Iterator[str]:
    for what, stated, found in pairs:
        if stated != found:
            yield f"{name}: {what} is {stated} in metadata.yaml and {found} in the files"


class GapCounter:
    """Counter of sequence numbers that are missing among the messages of a topic.

    The order of messages published at the same time may differ from the order of their numbers.
    """

    def __init__(self) -> None:
        self._count = 0
        self._first: int | None = None
        self._last = 0

    @property
    def missing(self) -> int:
        """Number of sequence numbers missing between the lowest and the highest that was added."""
        return 0 if self._first is None else self._last - self._first + 1 - self._count

    def add(self, number: int) -> bool:
        """Add a message's sequence number; return whether numbers directly before it are missing.

        Args:
            number: Sequence number; 0 for a repeated message, which is ignored.
        """
        if number == 0:
            return False
        before = self._last
        is_first = self._first is None
        self._count += 1
        self._first = number if self._first is None else min(self._first, number)
        self._last = max(before, number)
        return not is_first and number > before + 1


DATABASE_SUFFIX = ".db3"


def bag_file_faults(file: Path) -> Iterator[Fault]:
    """Read a whole MCAP or SQLite file of a bag, also compressed; yield each `Fault` found."""
    if file.suffix == SUFFIX:
        with TemporaryFolder(Path(gettempdir())) as folder:
            yield from _faults_inside(file, folder)
    elif file.suffix == DATABASE_SUFFIX:
        from teleopctl.bag.storage.sqlite_reader import SqliteFileReader
        from teleopctl.bag.storage.sqlite_writer import is_left_open

        if is_left_open(file):
            yield Fault(
                "was not finished: programs that ignore SQLite's log beside it miss messages",
                is_finishable=True,
            )
        try:
            with SqliteFileReader(file) as reader:
                yield from (Fault(what, loses=True) for what in reader.check())
        except InvalidFileError as error:
            yield Fault(error.message, loses=True)
    else:
        yield from mcap_file_faults(file)


def _faults_inside(file: Path, folder: Path) -> Iterator[Fault]:
    try:
        plain, fault = unpack_file(file, folder)
    except InvalidFileError as error:
        yield Fault(error.message, loses=True)
        return
    if fault:
        yield Fault(fault, loses=True)
    else:
        # A file inside a compressed one cannot be repaired in place.
        yield from (found._replace(is_finishable=False) for found in bag_file_faults(plain))


class BagFault(NamedTuple):
    """Fault of a bag that `check` found: the file or topic that has it, and what is wrong.

    Attributes:
        place: Path of the file, or name of the topic.
        what: Description of the fault, in one sentence.
    """

    place: str
    what: str


def check(path: Path, on_progress: ProgressCallback = lambda _done: None) -> Iterator[BagFault]:
    """Read a whole bag; yield a `BagFault` for each fault of files, metadata, types and messages.

    Checked are the ends, checksums and indexes of the files; ``metadata.yaml`` against the files;
    and of the topics the definitions and hashes, messages that cannot be decoded, missing sequence
    numbers, and times that go back.

    Args:
        path: Folder or file of the bag.
        on_progress: Called with the part of the bag's time span that is checked, from 0 to 1.

    Raises:
        NotFoundError: The bag does not exist.
        InvalidFileError: No part of the bag can be read.
    """
    with open_bag(path) as bag:
        files = [file for file in bag_files(path) if file.exists() and file.suffix != ".bag"]
        found_in_files = False
        for file in files:
            for fault in bag_file_faults(file):
                found_in_files = True
                yield BagFault(str(file), fault.what)
        yield from _metadata_findings(path, bag)
        topics = {topic.name: _TopicCheck(topic) for topic, _ in bag.metadata.topics}
        for topic_check in topics.values():
            yield from topic_check.findings_of_type()
        broken: list[str] = []
        start_ns = bag.metadata.start_ns
        length_ns = max(1, bag.metadata.duration_ns)
        try:
            for message in bag.messages(on_left_out=broken.append):
                topics[message.topic].add(message)
                on_progress((message.log_time_ns - start_ns) / length_ns)
        except InvalidFileError as error:
            # Damage was already found in the files; an exceeded limit was not.
            if not found_in_files:
                yield BagFault(str(path), error.message.removeprefix(f"Cannot read {path}: "))
                return
        for topic, count in bag.metadata.topics:
            yield from topics[topic.name].findings(count)


def _metadata_findings(path: Path, bag: Bag) -> Iterator[BagFault]:
    file = path / METADATA_FILE
    if not path.is_dir():
        return
    if not file.exists():
        yield BagFault(str(file), "is missing (teleopctl bag reindex writes it)")
        return
    try:
        stated = read_metadata(path)
    except InvalidFileError as error:
        yield BagFault(str(file), error.message.removeprefix(f"{file}: "))
        return
    for sentence in metadata_differences(stated, bag.metadata):
        yield BagFault(str(file), sentence)


class _TopicCheck:
    """Faults of one topic, collected while its messages are read."""

    def __init__(self, topic: BagTopic) -> None:
        self._topic = topic
        self._sequences = GapCounter()
        self._first_gap_ns: int | None = None
        self._count = 0
        self._undecodable = 0
        self._reason = ""
        # Any: a class made from its definition.
        self._class: type[Any] | None = None
        self._fault = ""
        if topic.serialization_format == CDR:
            try:
                self._class = topic_message_class(topic)
            except TeleopctlError as error:
                self._fault = error.message

    def findings_of_type(self) -> Iterator[BagFault]:
        """Yield the faults of the topic's type, type definition and type hash."""
        topic = self._topic
        if not topic.type_name:
            yield BagFault(topic.name, "it has no type")
        elif not topic.definition.encoding:
            yield BagFault(topic.name, f"the bag has no definition of {topic.type_name}")
        if self._fault:
            yield BagFault(topic.name, self._fault)
        found = ""
        if self._class is not None and topic.definition.encoding == ROS2MSG:
            found = hash_of_text(topic.type_name, topic.definition.text)
        if topic.type_hash and found and found != topic.type_hash:
            yield BagFault(
                topic.name,
                f"its definition has the hash {found} but the bag states {topic.type_hash}",
            )

    def add(self, message: BagMessage) -> None:
        """Check a message: note if it cannot be decoded or earlier sequence numbers are missing."""
        self._count += 1
        if self._topic.is_counted and self._sequences.add(message.sequence):
            self._first_gap_ns = self._first_gap_ns or message.log_time_ns
        if self._class is None:
            return
        try:
            deserialize(message.data, self._class)
        except TeleopctlError as error:
            self._undecodable += 1
            self._reason = self._reason or f"at {message.log_time_ns}: {error.message}"

    def findings(self, count: int) -> Iterator[BagFault]:
        """Yield the faults found in the topic's messages, after all messages were added.

        Args:
            count: Number of messages that the bag states.
        """
        name = self._topic.name
        if self._count != count:
            yield BagFault(name, f"{count} messages are stated, {self._count} can be read")
        if self._undecodable:
            yield BagFault(
                name, f"{self._undecodable} messages cannot be decoded, the first {self._reason}"
            )
        if self._sequences.missing:
            yield BagFault(
                name,
                f"{self._sequences.missing} messages were sent and are missing, by the recorder's"
                f" count; the first before {self._first_gap_ns}",
            )

"""A bag looked through for everything that may be wrong with it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.bag.editing.agreement import disagreements
from teleopctl.bag.editing.copying import Told
from teleopctl.bag.editing.faults import faults_of
from teleopctl.bag.editing.sequences import Sequences
from teleopctl.bag.look.decoding import class_of
from teleopctl.bag.metadata import METADATA_FILE, read_metadata
from teleopctl.bag.records import CDR, ROS2MSG, BagMessage, BagTopic
from teleopctl.bag.storage.bag import Bag, bag_files, open_bag
from teleopctl.errors import InvalidFileError, TeleopctlError
from teleopctl.interfaces import deserialize, hash_of_text


class BagFault(NamedTuple):
    """A fault of a bag.

    Attributes:
        place: The file, or the topic.
        what: What is wrong, in one sentence.
    """

    place: str
    what: str


def check(path: Path, told: Told = lambda _done: None) -> Iterator[BagFault]:
    """Read a whole bag; yield its faults.

    Files: their ends, checksums, and indexes against what they index. ``metadata.yaml`` against the
    files. Topics: definitions and hashes, messages that cannot be decoded, numbers of messages
    that are missing, and times that go back.

    Args:
        path: The bag, its folder or a file.
        told: Progress.

    Raises:
        NotFoundError: There is no bag.
        InvalidFileError: Nothing of it can be read.
    """
    with open_bag(path) as bag:
        files = [file for file in bag_files(path) if file.exists() and file.suffix != ".bag"]
        found_in_files = False
        for file in files:
            for fault in faults_of(file):
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
            for message in bag.messages(left_out=broken.append):
                topics[message.topic].add(message)
                told((message.log_time_ns - start_ns) / length_ns)
        except InvalidFileError as error:
            # Damage was found in the files already; what is over the budget was not.
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
        yield BagFault(str(file), "is missing (teleopctl bag reindex makes it)")
        return
    try:
        said = read_metadata(path)
    except InvalidFileError as error:
        yield BagFault(str(file), error.message.removeprefix(f"{file}: "))
        return
    for sentence in disagreements(said, bag.metadata):
        yield BagFault(str(file), sentence)


class _TopicCheck:
    """The messages of one topic."""

    def __init__(self, topic: BagTopic) -> None:
        self._topic = topic
        self._sequences = Sequences()
        self._first_gap_ns: int | None = None
        self._count = 0
        self._undecodable = 0
        self._reason = ""
        # Any: a class made from its definition.
        self._class: type[Any] | None = None
        self._fault = ""
        if topic.serialization_format == CDR:
            try:
                self._class = class_of(topic)
            except TeleopctlError as error:
                self._fault = error.message

    def findings_of_type(self) -> Iterator[BagFault]:
        """Yield the faults of the topic's type definition."""
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
                f"its definition has the hash {found} and not, as is said, {topic.type_hash}",
            )

    def add(self, message: BagMessage) -> None:
        """Check a message."""
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
        """Yield the faults of the topic's messages.

        Args:
            count: How many the bag says that it has.
        """
        name = self._topic.name
        if self._count != count:
            yield BagFault(name, f"{count} messages are said, {self._count} can be read")
        if self._undecodable:
            yield BagFault(
                name, f"{self._undecodable} messages cannot be decoded, the first {self._reason}"
            )
        if self._sequences.lost:
            yield BagFault(
                name,
                f"{self._sequences.lost} messages were sent and are missing, by the recorder's"
                f" count; the first before {self._first_gap_ns}",
            )

"""Base classes of open bags, and of a bag's files opened for reading or for writing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Self

from teleopctl.bag.metadata import BagFile
from teleopctl.bag.records import NO_TIME_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping
    from pathlib import Path

    from teleopctl.bag.metadata import BagMetadata
    from teleopctl.bag.records import BagAttachment, BagMessage, BagTopic


class _MessageReader(ABC):
    """Base of open bags and of their files: reads messages, attachments and metadata records."""

    @abstractmethod
    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages by log time; report broken parts to ``on_left_out``, or raise without it.

        Args:
            topics: Topics to read; all if None.
            start_ns: Earliest log time to read, in nanoseconds since the epoch.
            end_ns: Log time before which reading ends, in nanoseconds since the epoch.
            on_left_out: Called with a sentence for each broken part, whose messages are skipped;
                if None, a broken part raises an error.

        Raises:
            InvalidFileError: A part is broken, and `on_left_out` is None; names the place.
        """

    @abstractmethod
    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return up to `most` last messages of a topic before a log time, oldest first.

        Unreadable parts are skipped.

        Args:
            topic: Full name of the topic.
            end_ns: Log time before which messages are searched, in nanoseconds since the epoch.
            most: Largest number of messages.
        """

    @abstractmethod
    def attachments(self) -> Iterator[BagAttachment]:
        """Yield the attachments of the bag; none if the storage format has none."""

    @abstractmethod
    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield (name, values by key) of each metadata record of the bag."""

    @abstractmethod
    def close(self) -> None:
        """Close the files of the bag."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Bag(_MessageReader):
    """Bag opened for reading, as returned by `open_bag`: messages, attachments and metadata.

    Attributes:
        path: Folder or file of the bag.
        metadata: Files, times, topics and message counts.
        remarks: Problems of the bag, one sentence each, such as an unfinished file.

    Example:
        >>> with open_bag("session") as bag:
        ...     for topic, count in bag.metadata.topics:
        ...         print(topic.name, topic.type_name, count)
        /joint_states sensor_msgs/msg/JointState 3
    """

    path: Path
    metadata: BagMetadata
    remarks: list[str]


class BagView(Bag):
    """Base class of views of an open bag, with its attachments and metadata records.

    Args:
        bag: Open bag, which is closed with the view.
    """

    def __init__(self, bag: Bag) -> None:
        self._bag = bag
        self.path = bag.path
        self.metadata = bag.metadata
        self.remarks = bag.remarks

    def attachments(self) -> Iterator[BagAttachment]:
        """Yield the attachments of the bag."""
        return self._bag.attachments()

    def records(self) -> Iterator[tuple[str, dict[str, str]]]:
        """Yield the metadata records of the bag."""
        return self._bag.records()

    def close(self) -> None:
        """Close the bag."""
        self._bag.close()


class BagFileReader(_MessageReader):
    """Base class of readers of one file of a bag: MCAP or SQLite.

    Attributes:
        STORAGE: Storage format of the file: ``mcap`` or ``sqlite3``.
        path: Path of the file.
        topics: Topics by name, each with its number of messages.
        is_finished: Whether the file is complete; an incomplete or damaged file is read as far as
            possible.
        remarks: Unreadable parts of the file that are skipped, one sentence each.
        distribution: ROS 2 distribution that recorded the file; empty if unknown.
    """

    STORAGE: ClassVar[str]

    path: Path
    topics: dict[str, tuple[BagTopic, int]]
    is_finished: bool
    remarks: list[str]
    distribution: str

    @property
    @abstractmethod
    def description(self) -> BagFile:
        """The file's `BagFile` entry for ``metadata.yaml``: name, times and message count."""


class BagFileWriter(ABC):
    """Base class of writers of one file of a bag, which count messages and times.

    Args:
        path: Path of the file.

    Attributes:
        path: Path of the file.
        message_counts: Number of messages by topic.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.message_counts: dict[str, int] = {}
        self._first_ns: int | None = None
        self._last_ns = 0

    @property
    def is_empty(self) -> bool:
        """Whether no message was written to the file yet."""
        return self._first_ns is None

    @property
    def start_ns(self) -> int:
        """Earliest log time in nanoseconds since the epoch; 0 for a file without messages."""
        return self._first_ns or 0

    @property
    def description(self) -> BagFile:
        """The file's `BagFile` entry for ``metadata.yaml``: name, times and message count."""
        if self._first_ns is None:
            return BagFile(self.path.name)
        count = sum(self.message_counts.values())
        return BagFile(self.path.name, self._first_ns, self._last_ns - self._first_ns, count)

    @property
    @abstractmethod
    def size(self) -> int:
        """Size of the file so far in bytes, by which `BagWriter` decides to split the bag."""

    @abstractmethod
    def add_topic(self, topic: BagTopic) -> None:
        """Add a topic to the file, before the topic's first message; idempotent."""

    @abstractmethod
    def write(self, message: BagMessage) -> None:
        """Write or buffer a message of a topic that was added to the file."""

    @abstractmethod
    def attach(self, attachment: BagAttachment) -> None:
        """Add an attachment to the file; do nothing if the storage format has no attachments."""

    @abstractmethod
    def add_record(self, name: str, values: Mapping[str, str]) -> None:
        """Add a metadata record to the file, if the storage format has metadata records."""

    @abstractmethod
    def flush(self) -> None:
        """Write buffered messages to the operating system, to keep them if the process dies."""

    @abstractmethod
    def sync(self) -> None:
        """Wait until flushed data is on the disk (fsync); not for the thread that writes."""

    @abstractmethod
    def close(self) -> None:
        """Write buffered messages and the end of the file, and close the file."""

    @abstractmethod
    def abandon(self) -> None:
        """Close the file after a write error, without finishing it."""

    def _count(self, message: BagMessage) -> None:
        """Update the message counts and the times."""
        time_ns = message.log_time_ns
        if self._first_ns is None or time_ns < self._first_ns:
            self._first_ns = time_ns
        if time_ns > self._last_ns:
            self._last_ns = time_ns
        self.message_counts[message.topic] += 1

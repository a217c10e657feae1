"""``rosbag2_py._reader``. Reading of bags, message by message."""

import re
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

from rosbag2_py._storage import (
    STORAGES,
    BagMetadata,
    ConverterOptions,
    MessageDefinition,
    ReadOrder,
    ReadOrderSortBy,
    StorageFilter,
    StorageOptions,
    TopicMetadata,
    errors_of_rosbag2,
    metadata_of,
    topics_of,
)
from teleopctl import bag

__all__ = ["SequentialCompressionReader", "SequentialReader", "get_registered_readers"]

# Time that is read at once in reverse order, whose messages are in memory.
_WINDOW_NS = 10 * 10**9


class SequentialReader:
    """Reader of the messages of a bag by time, as bytes.

    Example:
        >>> reader = SequentialReader()
        >>> reader.open(StorageOptions(uri="session"), ConverterOptions())
        >>> while reader.has_next():
        ...     topic, data, time_ns = reader.read_next()
    """

    def __init__(self) -> None:
        self._bag: bag.Bag | None = None
        self._path = Path()
        self._options = StorageOptions(uri="")
        self._filter = StorageFilter()
        self._reverse = False
        self._start_ns = 0
        self._end_ns = bag.NO_TIME_NS
        self._messages: Iterator[bag.BagMessage] | None = None
        self._next: bag.BagMessage | None = None
        # The last message that was read, by its time, its topic, and its number among the messages
        # of both: after a change of the filter, reading continues after it.
        self._read: tuple[int, str, int] | None = None
        self._read_then: dict[str, int] = {}

    def open(
        self,
        storage_options: StorageOptions,
        converter_options: ConverterOptions | None = None,  # noqa: ARG002 -- checked when made
    ) -> None:
        """Open a bag.

        Raises:
            RuntimeError: There is no bag, or it cannot be read.
        """
        self.close()
        self._options = storage_options
        self._path = Path(storage_options.uri)
        with errors_of_rosbag2():
            self._bag = bag.open_bag(self._path, storage_options.storage_id or None)
        self._start_ns = max(0, storage_options.start_time_ns)
        end_ns = storage_options.end_time_ns
        self._end_ns = end_ns + 1 if end_ns >= 0 else bag.NO_TIME_NS
        self._begin()

    def open_uri(self, uri: str) -> None:
        """Open a bag by its path; raises as `open`."""
        self.open(StorageOptions(uri=uri))

    def close(self) -> None:
        """Close the bag."""
        if self._bag is not None:
            self._bag.close()
        self._bag = self._messages = self._next = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.close()

    def has_next(self) -> bool:
        """Return whether there is another message.

        Raises:
            RuntimeError: No bag is open, or the bag is damaged at this place.
        """
        if self._next is None:
            if self._messages is None:
                self._messages = self._iterate()
            with errors_of_rosbag2():
                self._next = next(self._messages, None)
        return self._next is not None

    def read_next(self) -> tuple[str, bytes, int]:
        """Return topic, bytes and time of receipt in nanoseconds of the next message.

        Raises:
            RuntimeError: There is no further message, or no bag is open.
        """
        if not self.has_next() or self._next is None:
            raise RuntimeError("Bag is at end. No next message.")
        message, self._next = self._next, None
        if self._read is None or self._read[0] != message.log_time_ns:
            self._read_then.clear()
        number = self._read_then[message.topic] = self._read_then.get(message.topic, 0) + 1
        self._read = message.log_time_ns, message.topic, number
        return message.topic, bytes(message.data), message.log_time_ns

    def get_metadata(self) -> BagMetadata:
        """Return the metadata of the bag."""
        return metadata_of(self._opened().metadata, self._path)

    def get_all_topics_and_types(self) -> list[TopicMetadata]:
        """Return the topics of the bag."""
        return [one.topic_metadata for one in topics_of(self._opened().metadata)]

    def get_all_message_definitions(self) -> list[MessageDefinition]:
        """Return the definitions of the topics' types, each once."""
        found = {}
        for topic, _ in self._opened().metadata.topics:
            definition = topic.definition
            if not definition.text:
                definition = bag.known_definition(topic.type_name, topic.type_hash) or definition
            found[topic.type_name] = MessageDefinition(
                topic.type_name, definition.encoding, definition.text, topic.type_hash
            )
        return list(found.values())

    def set_filter(self, storage_filter: StorageFilter) -> None:
        """Read only some topics from now on, behind the messages that were read.

        Raises:
            RuntimeError: A regular expression is invalid.
        """
        for pattern in (storage_filter.regex, storage_filter.regex_to_exclude):
            try:
                re.compile(pattern)
            except re.error as error:
                raise RuntimeError(f"'{pattern}' is not a regular expression: {error}") from error
        self._filter = storage_filter
        self._messages = self._next = None

    def reset_filter(self) -> None:
        """Read all topics from now on."""
        self.set_filter(StorageFilter())

    def seek(self, timestamp: int) -> None:
        """Go to the first message at a time or later; in reverse order, at a time or earlier.

        Args:
            timestamp: Nanoseconds since the epoch.
        """
        if self._reverse:
            self._end_ns = timestamp + 1
        else:
            self._start_ns = timestamp
        self._begin()

    def set_read_order(self, read_order: ReadOrder) -> bool:
        """Set the order of reading; return False for an order that is not possible.

        Messages are read by their times of receipt, forwards or in reverse.
        """
        if read_order.sort_by is not ReadOrderSortBy.ReceivedTimestamp:
            return False
        self._reverse = read_order.reverse
        self._begin()
        return True

    def _opened(self) -> bag.Bag:
        if self._bag is None:
            raise RuntimeError("Bag is not open. Call open() before reading.")
        return self._bag

    def _begin(self) -> None:
        self._messages = self._next = self._read = None
        self._read_then.clear()

    def _iterate(self) -> Iterator[bag.BagMessage]:
        """Yield the messages that are to be read behind those that were read."""
        start_ns, end_ns = self._start_ns, self._end_ns
        if self._read is not None:
            read_ns, topic, number = self._read
            then = list(self._messages_of(None, read_ns, read_ns + 1))
            read = [place for place, message in enumerate(then) if message.topic == topic]
            for message in then[read[number - 1] + 1 :]:
                if self._chooses(message.topic):
                    yield message
            start_ns, end_ns = (start_ns, read_ns) if self._reverse else (read_ns + 1, end_ns)
        topics = [one.name for one, _ in self._opened().metadata.topics if self._chooses(one.name)]
        yield from self._messages_of(topics, start_ns, end_ns)

    def _messages_of(
        self, topics: list[str] | None, start_ns: int, end_ns: int
    ) -> Iterator[bag.BagMessage]:
        """Yield messages in the order of reading; in reverse, some seconds are read at once."""
        source = self._opened()
        if not self._reverse:
            yield from source.messages(topics, start_ns, end_ns)
            return
        first_ns = max(start_ns, source.metadata.start_ns)
        end_ns = min(end_ns, source.metadata.end_ns + 1)
        while end_ns > first_ns:
            begin_ns = max(first_ns, end_ns - _WINDOW_NS)
            yield from reversed(list(source.messages(topics, begin_ns, end_ns)))
            end_ns = begin_ns

    def _chooses(self, topic: str) -> bool:
        chosen = self._filter
        if topic in chosen.exclude_topics or topic in chosen.exclude_service_events:
            return False
        if chosen.regex_to_exclude and re.fullmatch(chosen.regex_to_exclude, topic):
            return False
        if not (chosen.topics or chosen.services_events or chosen.regex):
            return True
        return (
            topic in chosen.topics
            or topic in chosen.services_events
            or bool(chosen.regex and re.fullmatch(chosen.regex, topic))
        )


class SequentialCompressionReader(SequentialReader):
    """Reader of compressed bags, which `SequentialReader` reads as well."""


def get_registered_readers() -> set[str]:
    """Return the storage formats that can be read."""
    return set(STORAGES)

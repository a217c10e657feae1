"""Decoding of a bag's messages, by the type definitions in the bag."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from teleopctl.bag.base import Bag
from teleopctl.bag.records import NO_TIME_NS, BagTopic
from teleopctl.bag.type_definitions import topic_message_class
from teleopctl.errors import InvalidMessageError, NotFoundError, TeleopctlError, did_you_mean
from teleopctl.interfaces import deserialize

PICTURES = frozenset({"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"})
"""The types that films are made of, and no tables."""


class DecodedMessage(NamedTuple):
    """Decoded message of a bag, with topic and times in nanoseconds since the epoch.

    Attributes:
        topic: Full name of the topic.
        log_time_ns: Time of receipt.
        publish_time_ns: Time of publication.
        message: The message, of a class with the fields of its type.

    Example:
        >>> for record in read_bag("session", ["/joint_states"]):
        ...     print(record.topic, record.log_time_ns, list(record.message.position))
        ...     break
        /joint_states 1000 [0.1, 0.2]
    """

    topic: str
    log_time_ns: int
    publish_time_ns: int
    # Any: its class is made from its definition.
    message: Any


class Decoder:
    """Reader of a bag that decodes messages by the type definitions in the bag.

    What cannot be read is passed over and counted: a bag may hold the messages of a broken node.

    Args:
        bag: The bag.
        topics: The topics; all that can be decoded if None.

    Attributes:
        topics: Those that can be decoded, by name, in the bag's order.
        left_out: Why the others cannot, by name.
        unreadable: How many messages could not be read so far, by topic.
        reasons: Why the first one of these could not.

    Raises:
        NotFoundError: The bag has no such topic.
        InvalidMessageError: A topic that was named cannot be decoded.
    """

    def __init__(self, bag: Bag, topics: Collection[str] | None = None) -> None:
        self.bag = bag
        self.topics: dict[str, BagTopic] = {}
        self.left_out: dict[str, str] = {}
        self.unreadable: dict[str, int] = {}
        self.reasons: dict[str, str] = {}
        self._classes: dict[str, type[Any]] = {}
        known = {topic.name: topic for topic, _ in bag.metadata.topics}
        for name in known if topics is None else topics:
            if name not in known:
                raise NotFoundError(
                    f"{bag.path} has no topic '{name}'",
                    hint=did_you_mean(name, known) or f"It has {', '.join(known) or 'none'}.",
                )
            try:
                self._classes[name] = topic_message_class(known[name])
                self.topics[name] = known[name]
            except TeleopctlError as error:
                if topics is not None:
                    raise InvalidMessageError(f"{name}: {error.message}") from error
                self.left_out[name] = error.message

    # Any: as above.
    def message_class(self, topic: str) -> type[Any]:
        """Return the class of the decoded messages of a topic."""
        return self._classes[topic]

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
    ) -> Iterator[DecodedMessage]:
        """Yield decoded messages of topics by log time; count those that cannot be decoded.

        Args:
            topics: Only these; all that can be decoded if None.
            start_ns: Only from this log time on.
            end_ns: Only up to this log time, and not at it.

        Raises:
            InvalidFileError: A part of the bag is broken.
        """
        self.unreadable.clear()
        wanted = self.topics.keys() if topics is None else topics
        for name, log_time_ns, publish_time_ns, data, *_ in self.bag.messages(
            wanted, start_ns, end_ns
        ):
            try:
                message = deserialize(data, self._classes[name])
            except TeleopctlError as error:
                self.unreadable[name] = self.unreadable.get(name, 0) + 1
                self.reasons.setdefault(name, error.message)
                continue
            yield DecodedMessage(name, log_time_ns, publish_time_ns, message)

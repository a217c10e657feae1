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
"""Image types: exported as videos, not as tables."""


class DecodedMessage(NamedTuple):
    """Decoded message of a bag, with topic and times in nanoseconds since the epoch.

    Attributes:
        topic: Full name of the topic.
        log_time_ns: Time of receipt.
        publish_time_ns: Time of publication.
        message: Decoded message, whose class has the fields of the type.

    Example:
        >>> for record in read_bag("session", ["/joint_states"]):
        ...     print(record.topic, record.log_time_ns, list(record.message.position))
        ...     break
        /joint_states 1000 [0.1, 0.2]
    """

    topic: str
    log_time_ns: int
    publish_time_ns: int
    # Any: the class is created from the type definition in the bag.
    message: Any


class Decoder:
    """Reader of a bag that decodes messages by the type definitions in the bag.

    Messages that cannot be decoded are skipped and counted: a bag may hold messages of a faulty
    node.

    Args:
        bag: Bag to read.
        topics: Names of the topics to decode; all that can be decoded if None.

    Attributes:
        topics: Topics that can be decoded, by name.
        left_out: Reason for each topic that cannot be decoded, by name.
        unreadable: Number of messages that could not be decoded so far, by topic.
        reasons: Error of the first message that could not be decoded, by topic.

    Raises:
        NotFoundError: The bag does not have one of the topics.
        InvalidMessageError: One of the named topics cannot be decoded.
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

    # Any: the class is created from the type definition in the bag.
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
            topics: Names of the topics to read; all that can be decoded if None.
            start_ns: Earliest log time to read, in nanoseconds since the epoch.
            end_ns: Log time before which reading ends, in nanoseconds since the epoch.

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

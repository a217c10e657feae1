"""Kinds of recorded topics: messages, service events (introspection) and parts of actions.

The events of a service are on ``NAME/_service_event``, with a type that ends with ``_Event``.
"""

from __future__ import annotations

import enum
import re
import struct
from collections.abc import Iterable
from typing import NamedTuple

from teleopctl.bag.records import BagMessage

EVENT_TOPIC_SUFFIX = "/_service_event"
"""End of the name of the topic on which a service publishes its introspection events."""

_TYPE_SUFFIX = "_Event"

# service_msgs/msg/ServiceEventInfo at the start of every event: kind, stamp, client, number.
_EVENT_LITTLE = struct.Struct("<B3xiI16s4xq")
_EVENT_BIG = struct.Struct(">B3xiI16s4xq")
_CDR_HEADER_BYTES = 4
_REQUESTS = (0, 1)
_RESPONSES = (2, 3)


def is_service_event(topic: str, type_name: str) -> bool:
    """Return whether a topic, by name and type, carries service introspection events."""
    return (
        len(topic) > len(EVENT_TOPIC_SUFFIX)
        and topic.endswith(EVENT_TOPIC_SUFFIX)
        and "/srv/" in type_name
        and type_name.endswith(_TYPE_SUFFIX)
    )


def service_of(topic: str, type_name: str) -> tuple[str, str]:
    """Return name and type of the service whose introspection events are on a topic."""
    return topic.removesuffix(EVENT_TOPIC_SUFFIX), type_name.removesuffix(_TYPE_SUFFIX)


_ACTION_TOPIC = re.compile(
    r"(?P<action>.+)/_action/"
    rf"(?:feedback|status|(?:send_goal|cancel_goal|get_result){EVENT_TOPIC_SUFFIX})"
)


class TopicKind(enum.Enum):
    """Kind of a recorded topic: plain messages, service events, or part of an action."""

    TOPIC = enum.auto()
    SERVICE = enum.auto()
    ACTION = enum.auto()


def kind_of(topic: str, type_name: str) -> tuple[TopicKind, str]:
    """Return the kind of a topic, and the name of the topic, service or action it belongs to."""
    action = _ACTION_TOPIC.fullmatch(topic)
    if action:
        return TopicKind.ACTION, action["action"]
    if is_service_event(topic, type_name):
        return TopicKind.SERVICE, service_of(topic, type_name)[0]
    return TopicKind.TOPIC, topic


class ServiceCounts(NamedTuple):
    """Numbers of distinct recorded requests and responses of a service."""

    requests: int = 0
    responses: int = 0


class ServiceCounter:
    """Counter of distinct service requests and responses in recorded introspection events.

    Args:
        topics: Names of the topics with introspection events.
    """

    def __init__(self, topics: Iterable[str]) -> None:
        names = list(topics)
        self._requests: dict[str, set[tuple[bytes, int]]] = {name: set() for name in names}
        self._responses: dict[str, set[tuple[bytes, int]]] = {name: set() for name in names}

    def add(self, message: BagMessage) -> None:
        """Count an event's request or response, once for client and server; ignore others."""
        if message.topic not in self._requests:
            return
        data = message.data
        layout = _EVENT_LITTLE if len(data) > 1 and data[1] & 1 else _EVENT_BIG
        if len(data) < _CDR_HEADER_BYTES + layout.size:
            return
        kind, _, _, client, number = layout.unpack_from(data, _CDR_HEADER_BYTES)
        if kind in _REQUESTS:
            self._requests[message.topic].add((client, number))
        elif kind in _RESPONSES:
            self._responses[message.topic].add((client, number))

    def counts(self, topic: str) -> ServiceCounts:
        """Return the `ServiceCounts` so far of the service that an event topic belongs to."""
        return ServiceCounts(len(self._requests[topic]), len(self._responses[topic]))

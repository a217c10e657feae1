"""Services in bags: the events that services with introspection publish, as rosbag2 names them."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import NamedTuple

from teleopctl.bag.records import BagMessage

TOPIC_SUFFIX = "/_service_event"
_TYPE_SUFFIX = "_Event"

# service_msgs/msg/ServiceEventInfo, with which every event begins: kind, stamp, client, number.
_EVENT_LITTLE = struct.Struct("<B3xiI16s4xq")
_EVENT_BIG = struct.Struct(">B3xiI16s4xq")
_CDR_HEADER_BYTES = 4
_REQUESTS = (0, 1)
_RESPONSES = (2, 3)


def is_service_event(topic: str, type_name: str) -> bool:
    """Return whether a topic carries service introspection events."""
    return (
        len(topic) > len(TOPIC_SUFFIX)
        and topic.endswith(TOPIC_SUFFIX)
        and "/srv/" in type_name
        and type_name.endswith(_TYPE_SUFFIX)
    )


def service_of(topic: str, type_name: str) -> tuple[str, str]:
    """Return name and type of the service behind an event topic."""
    return topic.removesuffix(TOPIC_SUFFIX), type_name.removesuffix(_TYPE_SUFFIX)


class ServiceCounts(NamedTuple):
    """Numbers of requests and responses of a service."""

    requests: int = 0
    responses: int = 0


class ServiceCounter:
    """Counts the requests and responses of services, each once, by their introspection events.

    Args:
        topics: Names of the topics with their events.
    """

    def __init__(self, topics: Iterable[str]) -> None:
        names = list(topics)
        self._requests: dict[str, set[tuple[bytes, int]]] = {name: set() for name in names}
        self._responses: dict[str, set[tuple[bytes, int]]] = {name: set() for name in names}

    def add(self, message: BagMessage) -> None:
        """Count a service event; other messages are ignored."""
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
        """Return the counts of the service behind an event topic."""
        return ServiceCounts(len(self._requests[topic]), len(self._responses[topic]))

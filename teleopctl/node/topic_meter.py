"""Rate, bandwidth and age of topics, measured without decoding messages."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable

from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.node.generic_subscription import raw_message_class
from teleopctl.node.values.qos import qos_profile_sensor_data

if TYPE_CHECKING:
    from teleopctl.node.endpoints.subscription import Subscription
    from teleopctl.node.node import Node

# Rates are measured over this time, or over the time between two samples if that is longer.
_WINDOW_S = 5.0


class Traffic(NamedTuple):
    """Message rate and bandwidth of a topic, and the age of its last message.

    Attributes:
        rate_hz: Messages per second.
        bytes_per_s: Bytes of messages per second.
        age_s: Seconds since the last message; None if none was received.
    """

    rate_hz: float
    bytes_per_s: float
    age_s: float | None


class TopicMeter:
    """Meter of the rate, bandwidth and age of topics, for ``top`` and the viewer's page.

    Earlier messages of latched publishers are not requested, and do not count.

    Args:
        node: Node that subscribes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._counts: dict[tuple[str, str, str], _Count] = {}

    def follow(self, topics: Iterable[str]) -> None:
        """Set the topics to measure: subscribe to new topics, unsubscribe from topics left out.

        A topic is subscribed to once it has publishers, for each of their types and type hashes; so
        call this again when the graph has changed.
        """
        graph = self._node.graph()
        wanted = {
            (topic, publisher.type_name, publisher.type_hash)
            for topic in topics
            for publisher in graph.publishers(topic)
        }
        for gone in self._counts.keys() - wanted:
            self._node.destroy_subscription(self._counts.pop(gone).subscription)
        for new in wanted - self._counts.keys():
            self._counts[new] = _Count(self._node, *new)

    def sample(self) -> dict[str, Traffic]:
        """Return the traffic of each measured topic over the last 5 s; call it once a second.

        The rates are those since the call that was 5 s ago.
        """
        now_s = time.monotonic()
        found: dict[str, Traffic] = {}
        for (topic, _, _), count in self._counts.items():
            traffic = count.sample(now_s)
            other = found.get(topic)
            found[topic] = traffic if other is None else _sum(traffic, other)
        return found


class _Count:
    """Counter for one type of one topic, updated on Zenoh's thread."""

    def __init__(self, node: Node, topic: str, type_name: str, type_hash: str) -> None:
        self.messages = 0
        self.bytes = 0
        self.last_s: float | None = None
        self._samples: deque[tuple[float, int, int]] = deque()
        self._samples.append((time.monotonic(), 0, 0))
        self.subscription: Subscription[Any] = node.create_subscription(
            raw_message_class(type_name, type_hash),
            topic,
            lambda payload: self._take(len(payload)),
            qos_profile_sensor_data,
            raw=True,
            immediate=True,
        )
        self.subscription.count_bytes(self._take)

    def _take(self, size: int) -> None:
        self.messages += 1
        self.bytes += size
        self.last_s = time.monotonic()

    def sample(self, now_s: float) -> Traffic:
        while len(self._samples) > 1 and now_s - self._samples[1][0] >= _WINDOW_S:
            self._samples.popleft()
        since_s, messages, count = self._samples[0]
        self._samples.append((now_s, self.messages, self.bytes))
        passed_s = max(now_s - since_s, 1e-3)
        return Traffic(
            (self.messages - messages) / passed_s,
            (self.bytes - count) / passed_s,
            None if self.last_s is None else max(0.0, now_s - self.last_s),
        )


def _sum(one: Traffic, other: Traffic) -> Traffic:
    ages = [age for age in (one.age_s, other.age_s) if age is not None]
    return Traffic(
        one.rate_hz + other.rate_hz, one.bytes_per_s + other.bytes_per_s, min(ages, default=None)
    )

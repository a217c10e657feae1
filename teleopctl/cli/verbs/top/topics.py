"""How often and how much topics carry, counted without decoding."""

from __future__ import annotations

import time
from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.errors import TeleopctlError
from teleopctl.node import Subscription, subscribe_undecoded

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.wire import Graph

HEAVY_TYPES = frozenset(
    {
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/PointCloud",
        "sensor_msgs/msg/PointCloud2",
    }
)
"""What is not listened to unasked: a robot's link may be too slow, a camera may begin to render."""

_WINDOW_S = 5.0


class TopicRow(NamedTuple):
    """A topic as it stands.

    Attributes:
        name: Full name.
        type_name: Its type, the first if it has several.
        publishers: How many there are.
        subscriptions: How many there are, without ours.
        is_measured: Whether it is listened to.
        rate: Messages per second in the last seconds.
        bandwidth: Bytes per second in the last seconds.
        age_s: Seconds since the last message; None before the first.
    """

    name: str
    type_name: str
    publishers: int
    subscriptions: int
    is_measured: bool
    rate: float = 0.0
    bandwidth: float = 0.0
    age_s: float | None = None


class _Count:
    """What one topic has carried: bytes and messages so far, and as they were at the last looks."""

    def __init__(self, now_s: float) -> None:
        self.subscription: Subscription[Any] | None = None
        self.messages = self.bytes = 0
        self.last_s: float | None = None
        self.looks: deque[tuple[float, int, int]] = deque([(now_s, 0, 0)])

    def arrive(self, payload: bytes) -> None:
        self.messages += 1
        self.bytes += len(payload)
        self.last_s = time.monotonic()

    def look(self, now_s: float) -> tuple[float, float, float | None]:
        """Rate, bandwidth and age."""
        self.looks.append((now_s, self.messages, self.bytes))
        while len(self.looks) > 2 and now_s - self.looks[1][0] >= _WINDOW_S:
            self.looks.popleft()
        then_s, messages, size = self.looks[0]
        span_s = max(now_s - then_s, 1e-9)
        age_s = None if self.last_s is None else max(0.0, now_s - self.last_s)
        return (self.messages - messages) / span_s, (self.bytes - size) / span_s, age_s


class Topics:
    """Listens to the topics that somebody looks at.

    Args:
        node: Subscribes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._counts: dict[tuple[str, str], _Count] = {}

    def look(self, graph: Graph) -> list[TopicRow]:
        """All topics that are not hidden."""
        now_s = time.monotonic()
        own = self._node.get_fully_qualified_name()
        rows = []
        for name, types in graph.topic_names_and_types():
            publishers = graph.publishers(name)
            others = [s for s in graph.subscriptions(name) if s.full_name != own]
            if not publishers and not others:
                continue  # it is there because we listen to it
            type_name = (publishers or others)[0].type_name if len(types) > 1 else types[0]
            counted = self._counts.get((name, type_name))
            numbers = counted.look(now_s) if counted else ()
            rows.append(
                TopicRow(
                    name,
                    type_name,
                    len(publishers),
                    len(others),
                    counted is not None,
                    *numbers,
                )
            )
        return rows

    def listen_to(self, wanted: set[tuple[str, str]]) -> None:
        """Listen to these topics, by name and type, and to no others."""
        for key in self._counts.keys() - wanted:
            count = self._counts.pop(key)
            if count.subscription is not None:
                self._node.destroy_subscription(count.subscription)
        for key in wanted - self._counts.keys():
            count = self._counts[key] = _Count(time.monotonic())
            try:
                count.subscription = subscribe_undecoded(self._node, *key, count.arrive)
            except TeleopctlError:
                continue  # of an unknown type, and without a publisher: nothing can arrive

"""Topics of the graph, with rate, bandwidth and age of those that are measured."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.node import TopicMeter, Traffic

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
"""Types measured on request only: the network may be too slow, and cameras start to render."""


class TopicRow(NamedTuple):
    """Row of a topic: type, endpoints and traffic.

    Attributes:
        name: Full name of the topic.
        type_name: Type of the topic; the first one if the topic has several.
        publishers: Number of publishers.
        subscriptions: Number of subscriptions, without that of the meter.
        traffic: Rate, bandwidth and age; None while the topic is not measured.
    """

    name: str
    type_name: str
    publishers: int
    subscriptions: int
    traffic: Traffic | None = None

    @property
    def bytes_per_s(self) -> float:
        """Bytes per second; zero while the topic is not measured."""
        return self.traffic.bytes_per_s if self.traffic else 0.0


class TopicTable:
    """Topic rows of ``teleopctl top``; subscribes to the topics set by `measure` to measure them.

    Args:
        node: Node that subscribes to the measured topics.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._meter = TopicMeter(node)

    def rows(self, graph: Graph) -> list[TopicRow]:
        """Return rows of all topics that are not hidden, with the latest measurements."""
        own = self._node.get_fully_qualified_name()
        traffic = self._meter.sample()
        rows = []
        for name, types in graph.topic_names_and_types():
            publishers = graph.publishers(name)
            others = [s for s in graph.subscriptions(name) if s.full_name != own]
            if not publishers and not others:
                continue  # only the meter subscribes to this topic
            type_name = (publishers or others)[0].type_name if len(types) > 1 else types[0]
            rows.append(TopicRow(name, type_name, len(publishers), len(others), traffic.get(name)))
        return rows

    def measure(self, topics: Iterable[str]) -> None:
        """Replace the set of topics that are measured, by name."""
        self._meter.follow(topics)

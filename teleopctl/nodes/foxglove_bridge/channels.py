"""Channels from ROS topics to Foxglove clients, subscribed while a client needs them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from foxglove import Channel, Context, Schema

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import complete_definition_text, type_hash
from teleopctl.node import (
    Node,
    QoSProfile,
    ReliabilityPolicy,
    Subscription,
    add_type_from_graph,
    create_generic_subscription,
    qos_for_publishers,
)
from teleopctl.nodes.foxglove_bridge.settings import BridgeSettings, allows

if TYPE_CHECKING:
    from typing import Any

    from teleopctl.wire import Graph

_LONGEST_LEARNING_S = 2.0


class _Open:
    """A channel, its clients, and the ROS subscription while the channel has clients."""

    def __init__(self, channel: Channel, topic: str, type_name: str) -> None:
        self.channel = channel
        self.topic = topic
        self.type_name = type_name
        self.clients: set[int] = set()
        self.subscription: Subscription[Any] | None = None


class Channels:
    """Foxglove channels, one per ROS topic and type; only for the executor's thread.

    Args:
        node: Node that subscribes to the topics.
        settings: Settings with the allowed topics and QoS limits.
        context: Foxglove context of the server.
    """

    def __init__(self, node: Node, settings: BridgeSettings, context: Context) -> None:
        self._node = node
        self._settings = settings
        self._context = context
        self._open: dict[tuple[str, str], _Open] = {}
        self._by_id: dict[int, _Open] = {}

    def update(self, graph: Graph) -> None:
        """Open Foxglove channels for new topics of the ROS graph; close those of removed topics."""
        wanted = {
            (topic, type_name)
            for topic, types in graph.topic_names_and_types(self._settings.includes_hidden)
            if allows(self._settings.topics, topic)
            for type_name in types
        }
        for key in [key for key in self._open if key not in wanted]:
            entry = self._open.pop(key)
            del self._by_id[entry.channel.id()]
            self._stop(entry)
            entry.channel.close()
        for topic, type_name in sorted(wanted - self._open.keys()):
            self._add(graph, topic, type_name)

    def subscribe(self, channel_id: int, client_id: int) -> None:
        """Add a client to a channel, and subscribe to the channel's ROS topic for it if needed."""
        entry = self._by_id.get(channel_id)
        if entry is None:
            return
        if entry.clients and entry.subscription and entry.subscription.qos_profile.is_latched:
            # The new client needs the latched messages. A new subscription sends them to all
            # clients, since the SDK does not expose the ID that addresses a single client.
            self._stop(entry)
        entry.clients.add(client_id)
        if entry.subscription is None:
            channel, clock = entry.channel, self._node.get_clock()

            def forward(payload: bytes) -> None:
                channel.log(payload, log_time=clock.now().nanoseconds)

            qos = self._qos(entry.topic, entry.type_name)
            entry.subscription = create_generic_subscription(
                self._node, entry.topic, entry.type_name, forward, qos=qos
            )

    def unsubscribe(self, channel_id: int, client_id: int) -> None:
        """Remove a client from a channel; after the last client, unsubscribe from the ROS topic."""
        entry = self._by_id.get(channel_id)
        if entry is not None:
            entry.clients.discard(client_id)
            if not entry.clients:
                self._stop(entry)

    def _add(self, graph: Graph, topic: str, type_name: str) -> None:
        schema = self._schema(graph, topic, type_name)
        channel = Channel(topic, message_encoding="cdr", schema=schema, context=self._context)
        entry = _Open(channel, topic, type_name)
        self._open[topic, type_name] = entry
        self._by_id[channel.id()] = entry

    def _schema(self, graph: Graph, topic: str, type_name: str) -> Schema | None:
        """Return a type's definition; None if unknown: clients then show raw bytes."""
        try:
            add_type_from_graph(self._node, type_name, graph, _LONGEST_LEARNING_S)
            text = complete_definition_text(type_name)
            ours = type_hash(type_name)
        except TeleopctlError as error:
            self._node.get_logger().warning(f"{topic}: without its definition: {error.message}")
            return None
        others = {publisher.type_hash for publisher in graph.publishers(topic, type_name)} - {ours}
        if others:
            self._node.get_logger().warning(
                f"{topic}: its publisher uses another version of {type_name} than this program "
                "(type hashes differ), so the topic is shown without its definition"
            )
            return None
        return Schema(name=type_name, encoding="ros2msg", data=text.encode())

    def _qos(self, topic: str, type_name: str) -> QoSProfile:
        offers = [p.qos for p in self._node.graph().publishers(topic, type_name)]
        depth = sum(max(1, offer.depth) for offer in offers)
        depth = min(max(depth, self._settings.min_depth, 1), max(self._settings.max_depth, 1))
        qos = qos_for_publishers(offers, depth)
        if allows(self._settings.best_effort_topics, topic):
            qos.reliability = ReliabilityPolicy.BEST_EFFORT
        return qos

    def _stop(self, entry: _Open) -> None:
        if entry.subscription is not None:
            self._node.destroy_subscription(entry.subscription)
            entry.subscription = None

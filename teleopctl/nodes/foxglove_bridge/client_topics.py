"""Channels from Foxglove clients to ROS topics: a publisher for each advertised channel."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.errors import RefusedError, UnsupportedError
from teleopctl.interfaces import get_message, message_from_yaml, normalize
from teleopctl.node import Node, Publisher, QoSProfile
from teleopctl.nodes.foxglove_bridge.settings import BridgeSettings, allows

if TYPE_CHECKING:
    from foxglove.websocket import ClientChannel

_DEPTH = 10
ENCODINGS = ("cdr", "json")
"""Encodings in which clients may send messages."""


class _Advertised(NamedTuple):
    publisher: Publisher[Any]
    message_class: type[Any]
    is_json: bool


class ClientTopics:
    """ROS publishers for the channels that Foxglove clients advertise; thread-safe.

    Args:
        node: Node that publishes the messages.
        settings: Settings with the topics that clients may publish.
    """

    def __init__(self, node: Node, settings: BridgeSettings) -> None:
        self._node = node
        self._settings = settings
        self._lock = threading.Lock()
        self._advertised: dict[tuple[int, int], _Advertised] = {}

    def advertise(self, client_id: int, channel: ClientChannel) -> None:
        """Create a ROS publisher for a channel that a Foxglove client advertises; raise if refused.

        Raises:
            TeleopctlError: The client may not publish the topic, or the channel's type or encoding
                is unknown.
        """
        if not allows(self._settings.client_topics, channel.topic):
            raise RefusedError(f"clients may not publish '{channel.topic}'")
        if channel.encoding not in ENCODINGS:
            raise UnsupportedError(
                f"'{channel.topic}': messages are written as {' or '.join(ENCODINGS)}, "
                f"not as '{channel.encoding}'"
            )
        message_class: type[Any] = get_message(normalize(channel.schema_name))
        others = [
            publisher
            for publisher in self._node.graph().publishers(channel.topic)
            if publisher.full_name != self._node.get_fully_qualified_name()
        ]
        qos = QoSProfile.from_wire(others[0].qos) if others else QoSProfile(depth=_DEPTH)
        publisher = self._node.create_publisher(message_class, channel.topic, qos)
        advertised = _Advertised(publisher, message_class, channel.encoding == "json")
        self._replace((client_id, channel.id), advertised)

    def unadvertise(self, client_id: int, channel_id: int) -> None:
        """Destroy the ROS publisher of a Foxglove client's channel."""
        self._replace((client_id, channel_id), None)

    def publish(self, client_id: int, channel_id: int, data: bytes) -> None:
        """Publish a message (CDR or JSON) that a Foxglove client sent on an advertised channel.

        Raises:
            TeleopctlError: The data is not a message of the channel's type.
        """
        with self._lock:
            advertised = self._advertised.get((client_id, channel_id))
        if advertised is None:
            return  # the channel was refused, and the client has received the error
        if advertised.is_json:
            text = data.decode(errors="replace")
            advertised.publisher.publish(message_from_yaml(advertised.message_class, text))
        else:
            advertised.publisher.publish(data)

    def _replace(self, key: tuple[int, int], advertised: _Advertised | None) -> None:
        with self._lock:
            before = self._advertised.pop(key, None)
            if advertised is not None:
                self._advertised[key] = advertised
        if before is not None:
            self._node.destroy_publisher(before.publisher)

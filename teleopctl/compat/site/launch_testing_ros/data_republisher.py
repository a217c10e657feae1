"""``launch_testing_ros.data_republisher``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

_DEPTH = 10


class DataRepublisher:
    """Republishes the messages of a topic on another one, changed by a function.

    Args:
        node: Has the publisher and the subscription.
        listen_topic: Topic to subscribe to.
        publish_topic: Topic to publish on.
        msg_type: Their type.
        transform_fn: Returns what is to be published for a message, or None for nothing.
    """

    # Any: messages of whatever type.
    def __init__(
        self,
        node: Node,
        listen_topic: str,
        publish_topic: str,
        msg_type: type[Any],
        transform_fn: Callable[[Any], Any],
    ) -> None:
        self._node = node
        self._transform = transform_fn
        self._received = 0
        self._republished: list[Any] = []
        self._publisher = node.create_publisher(msg_type, publish_topic, _DEPTH)
        self._subscription = node.create_subscription(
            msg_type, listen_topic, self._on_message, _DEPTH
        )

    def shutdown(self) -> None:
        """Destroy the subscription and the publisher."""
        self._node.destroy_subscription(self._subscription)
        self._node.destroy_publisher(self._publisher)

    def get_num_received(self) -> int:
        """Return the number of received messages."""
        return self._received

    def get_num_republished(self) -> int:
        """Return the number of messages that were published again."""
        return len(self._republished)

    def get_republished(self) -> list[Any]:
        """Return the messages that were published again, as received."""
        return self._republished

    def _on_message(self, message: Any) -> None:
        self._received += 1
        changed = self._transform(message)
        if changed:
            self._republished.append(message)
            self._publisher.publish(changed)

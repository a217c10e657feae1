"""Subscriptions that store the serialized messages of topics in the order of arrival."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.bag import BagMessage
from teleopctl.interfaces import type_hash
from teleopctl.node import DurabilityPolicy, Node, QoSProfile, raw_message_class
from tests.bag.bags import STRING

LONGEST_WAIT_S = 20


class Listener:
    """Subscriptions of a test's node that store the received messages.

    Attributes:
        received: Topic and serialized data of each received message, in the order of arrival.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._changed = threading.Condition()
        self.received: list[tuple[str, bytes]] = []

    def subscribe(
        self,
        topic: str,
        type_name: str = STRING,
        version: str | None = None,
        *,
        is_latched: bool = False,
    ) -> None:
        """Subscribe to a topic; ``version`` is the type hash of a type unknown in this process."""
        durability = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE

        def hear(data: bytes) -> None:
            with self._changed:
                self.received.append((topic, data))
                self._changed.notify_all()

        kind = raw_message_class(type_name, version or type_hash(type_name))
        qos = QoSProfile(depth=100, durability=durability)
        self._node.create_subscription(kind, topic, hear, qos, raw=True, immediate=True)
        if is_latched:
            # New messages are held back until the subscription has received the latched ones.
            publisher = self._node.create_publisher(kind, topic, qos)
            publisher.publish(b"\0\1\0\0")
            self.wait_for(lambda: (topic, b"\0\1\0\0") in self.received)
            self._node.destroy_publisher(publisher)
            self.received.remove((topic, b"\0\1\0\0"))

    def wait_for(self, has_come: Callable[[], bool]) -> None:
        """Wait until a condition on the received messages is true; fail after a timeout."""
        with self._changed:
            assert self._changed.wait_for(has_come, LONGEST_WAIT_S), self.received[-5:]

    def wait_for_count(self, count: int) -> None:
        """Wait until at least ``count`` messages have been received."""
        self.wait_for(lambda: len(self.received) >= count)


def as_received(messages: list[BagMessage]) -> list[tuple[str, bytes]]:
    """Return topic and data of messages, as `Listener.received` stores them."""
    return [(message.topic, message.data) for message in messages]

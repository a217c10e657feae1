"""Everything that comes on topics, byte for byte and in its order."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.bag import BagMessage
from teleopctl.interfaces import type_hash
from teleopctl.node import DurabilityPolicy, Node, QoSProfile, raw_message_class
from tests.bag.bags import STRING

LONGEST_WAIT_S = 20


class Listener:
    """Subscriptions of a node of the test's own.

    Attributes:
        received: Topic and bytes of each message.
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
        """Listen to a topic; ``version`` is the hash of a type that is unknown here."""
        durability = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE

        def hear(data: bytes) -> None:
            with self._changed:
                self.received.append((topic, data))
                self._changed.notify_all()

        kind = raw_message_class(type_name, version or type_hash(type_name))
        qos = QoSProfile(depth=100, durability=durability)
        self._node.create_subscription(kind, topic, hear, qos, raw=True, immediate=True)
        if is_latched:
            # Until it has got what was published before, it keeps back what is published.
            publisher = self._node.create_publisher(kind, topic, qos)
            publisher.publish(b"\0\1\0\0")
            self.wait_for(lambda: (topic, b"\0\1\0\0") in self.received)
            self._node.destroy_publisher(publisher)
            self.received.remove((topic, b"\0\1\0\0"))

    def wait_for(self, has_come: Callable[[], bool]) -> None:
        """Wait until what was received satisfies a condition."""
        with self._changed:
            assert self._changed.wait_for(has_come, LONGEST_WAIT_S), self.received[-5:]

    def wait_for_count(self, count: int) -> None:
        """Wait for so many messages."""
        self.wait_for(lambda: len(self.received) >= count)


def as_received(messages: list[BagMessage]) -> list[tuple[str, bytes]]:
    """What a listener gets of messages."""
    return [(message.topic, message.data) for message in messages]

"""Publishers that send only while their node is active."""

from __future__ import annotations

from teleopctl.interfaces import MessageT
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.lifecycle.managed_entity import SimpleManagedEntity
from teleopctl.node.node_core import NodeCore
from teleopctl.node.values.qos import QoSProfile


class LifecyclePublisher(SimpleManagedEntity, Publisher[MessageT]):
    """Publisher that drops messages unless activated; made by ``create_lifecycle_publisher``.

    It is in the graph from the beginning.
    """

    def __init__(
        self, node: NodeCore, msg_type: type[MessageT], topic: str, qos: QoSProfile
    ) -> None:
        SimpleManagedEntity.__init__(self)
        Publisher.__init__(self, node, msg_type, topic, qos)

    def publish(self, msg: MessageT | bytes | bytearray) -> None:
        """Send a message if the publisher is activated; see `Publisher.publish`."""
        if self.is_activated:
            Publisher.publish(self, msg)

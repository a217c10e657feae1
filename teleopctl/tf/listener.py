"""Fill a buffer with what others say of frames, with the names of ``tf2_ros``."""

from typing import Any

from teleopctl.interfaces.store import get_message
from teleopctl.node import DurabilityPolicy, Node, QoSProfile
from teleopctl.tf.broadcaster import TF_STATIC_TOPIC, TF_TOPIC
from teleopctl.tf.buffer import Buffer

_DEPTH = 100


class TransformListener:
    """Subscribes ``/tf`` and ``/tf_static``.

    Transforms enter the buffer as they arrive and not when an executor comes to it, so a callback
    may wait for a transform, whatever executor runs it.

    Args:
        buffer: What to fill.
        node: The node that subscribes.
        spin_thread: Accepted for tf2_ros's sake; no thread is needed.
        qos: Quality of service of ``/tf``.
        static_qos: Quality of service of ``/tf_static``.
    """

    def __init__(
        self,
        buffer: Buffer,
        node: Node,
        *,
        spin_thread: bool = False,
        qos: QoSProfile | int | None = None,
        static_qos: QoSProfile | int | None = None,
    ) -> None:
        self.buffer = buffer
        self.node = node
        self.spin_thread = spin_thread
        message = get_message("tf2_msgs/msg/TFMessage")
        latched = QoSProfile(depth=_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.tf_sub = node.create_subscription(
            message, TF_TOPIC, self._moved, qos or QoSProfile(depth=_DEPTH), immediate=True
        )
        self.tf_static_sub = node.create_subscription(
            message, TF_STATIC_TOPIC, self._stands, static_qos or latched, immediate=True
        )

    def unregister(self) -> None:
        """Stop listening."""
        self.node.destroy_subscription(self.tf_sub)
        self.node.destroy_subscription(self.tf_static_sub)

    def _moved(self, message: Any) -> None:
        for transform in message.transforms:
            self.buffer.set_transform(transform, "default_authority")

    def _stands(self, message: Any) -> None:
        for transform in message.transforms:
            self.buffer.set_transform_static(transform, "default_authority")

"""Subscriptions that fill a transform buffer, with the names of ``tf2_ros``."""

from typing import Any

from teleopctl.interfaces import get_message
from teleopctl.node import (
    DurabilityPolicy,
    MessageInfo,
    Node,
    QoSProfile,
    ReentrantCallbackGroup,
    SingleThreadedExecutor,
    spin_in_thread,
)
from teleopctl.tf.broadcaster import TF_STATIC_TOPIC, TF_TOPIC
from teleopctl.tf.buffer import Buffer

DEFAULT_TF_TOPIC = TF_TOPIC
DEFAULT_STATIC_TF_TOPIC = TF_STATIC_TOPIC

_DEPTH = 100
# As in tf2, which does not record publishers.
_ANYONE = "default_authority"
_UNKNOWN = "<no authority available>"


class Senders:
    """Cache of publishers' node names by GID, which also finds names of ended nodes seen before.

    Args:
        node: Node that receives the messages.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        node.graph()  # start the discovery now, so that the first message finds its publisher
        self._names: dict[bytes, str] = {}

    def name(self, gid: bytes) -> str:
        """Return the full node name of a publisher, or ``<no authority available>`` if unknown."""
        if gid not in self._names:
            for endpoint in self._node.graph().endpoints:
                if endpoint.gid == gid:
                    self._names[gid] = endpoint.full_name
        return self._names.get(gid, _UNKNOWN)


class TransformListener:
    """Subscriber to ``/tf`` and ``/tf_static`` that fills a buffer.

    Transforms are added to the buffer on arrival, without an executor, so a callback may wait for
    a transform with any executor. Each message also wakes the executor of the node: the executor
    completes the futures of the buffer, and ``spin_once`` returns.

    Args:
        buffer: Buffer that received transforms are added to.
        node: Node that the subscriptions belong to.
        spin_thread: Whether to spin the node in a thread, for a program that does not spin it.
        qos: QoS profile of ``/tf``; depth 100 if None.
        static_qos: QoS profile of ``/tf_static``; latched with depth 100 if None.
        tf_topic: Topic to subscribe to instead of ``/tf``.
        tf_static_topic: Topic to subscribe to instead of ``/tf_static``.
    """

    def __init__(
        self,
        buffer: Buffer,
        node: Node,
        *,
        spin_thread: bool = False,
        qos: QoSProfile | int | None = None,
        static_qos: QoSProfile | int | None = None,
        tf_topic: str = DEFAULT_TF_TOPIC,
        tf_static_topic: str = DEFAULT_STATIC_TF_TOPIC,
    ) -> None:
        self.buffer = buffer
        self.node = node
        self.spin_thread = spin_thread
        self._arrived = node.create_guard_condition(
            buffer.complete_futures, ReentrantCallbackGroup()
        )
        buffer.use_executor_of(node)
        message = get_message("tf2_msgs/msg/TFMessage")
        latched = QoSProfile(depth=_DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.tf_sub = node.create_subscription(
            message, tf_topic, self._moved, qos or QoSProfile(depth=_DEPTH), immediate=True
        )
        self.tf_static_sub = node.create_subscription(
            message, tf_static_topic, self._stands, static_qos or latched, immediate=True
        )

        if spin_thread:
            self._spin_in_thread()

    def _spin_in_thread(self) -> None:
        self.executor = SingleThreadedExecutor(context=self.node.context)
        self.executor.add_node(self.node)
        self.dedicated_listener_thread = spin_in_thread(self.executor, "tf")

    def unregister(self) -> None:
        """Unsubscribe from ``/tf`` and ``/tf_static``, and stop the spinning thread, if any."""
        if self.spin_thread:
            self.executor.shutdown()
        self.node.destroy_guard_condition(self._arrived)
        self.node.destroy_subscription(self.tf_sub)
        self.node.destroy_subscription(self.tf_static_sub)

    def _moved(self, message: Any, info: MessageInfo) -> None:
        authority = self._authority(info)
        for transform in message.transforms:
            self.buffer.set_transform(transform, authority)
        self._arrived.trigger()

    def _stands(self, message: Any, info: MessageInfo) -> None:
        authority = self._authority(info)
        for transform in message.transforms:
            self.buffer.set_transform_static(transform, authority)
        self._arrived.trigger()

    def _authority(self, _info: MessageInfo) -> str:
        """Return the authority that the buffer records for the transforms of a message."""
        return _ANYONE


class NamedTransformListener(TransformListener):
    """`TransformListener` that records which node published each transform.

    Args:
        buffer: Buffer that received transforms are added to.
        node: Node that the subscriptions belong to.
    """

    def __init__(self, buffer: Buffer, node: Node) -> None:
        self._senders = Senders(node)
        super().__init__(buffer, node)

    def _authority(self, info: MessageInfo) -> str:
        return self._senders.name(info["publisher_gid"])

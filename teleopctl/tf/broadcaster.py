"""Broadcasters of transforms, with the names of ``tf2_ros``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from teleopctl.interfaces import get_message
from teleopctl.node import Node, QoSProfile, qos_profile_latched

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

TF_TOPIC = "/tf"
TF_STATIC_TOPIC = "/tf_static"

_TF_DEPTH = 100


class TransformBroadcaster:
    """Publisher of transforms on ``/tf``, as in tf2_ros.

    Args:
        node: Node of the publisher.
        qos: QoS profile of the publisher, or the depth of its queue.
    """

    def __init__(self, node: Node, qos: QoSProfile | int = _TF_DEPTH) -> None:
        self._message = get_message("tf2_msgs/msg/TFMessage")
        self.pub_tf = node.create_publisher(self._message, TF_TOPIC, qos)

    def sendTransform(  # noqa: N802 -- tf2_ros's name
        self, transform: TransformStamped | Iterable[TransformStamped]
    ) -> None:
        """Publish one ``TransformStamped``, or several in one message, on ``/tf``."""
        self.pub_tf.publish(self._message(transforms=_as_list(transform)))


class StaticTransformBroadcaster:
    """Latched publisher of static transforms on ``/tf_static``; each message repeats earlier ones.

    A late subscriber receives the last message only, so each message holds all frames sent so far.

    Args:
        node: Node of the publisher.
        qos: QoS profile of the publisher; `qos_profile_latched` if None.
    """

    def __init__(self, node: Node, qos: QoSProfile | None = None) -> None:
        self._message = get_message("tf2_msgs/msg/TFMessage")
        self._transforms: dict[str, TransformStamped] = {}
        self.pub_tf = node.create_publisher(
            self._message, TF_STATIC_TOPIC, qos or qos_profile_latched
        )

    def sendTransform(  # noqa: N802 -- tf2_ros's name
        self, transform: TransformStamped | Iterable[TransformStamped]
    ) -> None:
        """Publish one or more static transforms, with all sent before for other child frames."""
        for each in _as_list(transform):
            self._transforms[each.child_frame_id] = each
        self.pub_tf.publish(self._message(transforms=list(self._transforms.values())))

    def forget(self) -> None:
        """Forget all transforms sent so far; later messages lack them (not in tf2)."""
        self._transforms.clear()


def _as_list(
    transform: TransformStamped | Iterable[TransformStamped],
) -> list[TransformStamped]:
    if isinstance(transform, Iterable):
        return list(transform)
    return [transform]

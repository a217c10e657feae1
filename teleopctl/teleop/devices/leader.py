"""Teleop device ``leader``: another arm of the graph, in simulation or not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from teleopctl.interfaces import get_message
from teleopctl.node import Node
from teleopctl.teleop.device import DeviceError, HandSample, TeleopDevice


class LeaderArm(TeleopDevice):
    """Joints of an arm, from its ``joint_states``.

    The parameter ``leader`` of its node is the arm's namespace.
    """

    mapping = "same_joints"
    gives_joints = True

    def __init__(self, node: Node, emit: Callable[[HandSample], object]) -> None:
        super().__init__(node, emit)
        given = str(node.declare_parameter("leader", "/leader").value)
        self.namespace = f"/{given.strip('/')}"
        self._sequence = 0

    def start(self) -> None:
        """Subscribe to the arm's states.

        Raises:
            DeviceError: The arm is the one that shall follow it.
        """
        topic = self.node.resolve_topic_name(f"{self.namespace.rstrip('/')}/joint_states")
        if topic == self.node.resolve_topic_name("joint_states"):
            raise DeviceError(
                f"The leader of {topic} is the follower itself",
                hint="Name the namespace of another arm with the parameter leader.",
            )
        # Any, here and below: message classes are generated at run time from definitions.
        kind: Any = get_message("sensor_msgs/msg/JointState")
        self._subscription: Any = self.node.create_subscription(kind, topic, self._received, 1)

    def stop(self) -> None:
        """Unsubscribe."""
        self.node.destroy_subscription(self._subscription)

    def _received(self, message: Any) -> None:
        self._sequence += 1
        joints = dict(zip(message.name, map(float, message.position), strict=False))
        self.emit(HandSample(joints=joints, sequence=self._sequence))

"""Topic ``~/controller_state`` of a joint trajectory controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.control.controllers.joint_trajectory.settings import TrajectorySettings
from teleopctl.control.controllers.joint_trajectory.trajectory import TrajectoryPoint
from teleopctl.control.realtime_publisher import PublishQueue, RealtimePublisher
from teleopctl.interfaces import set_stamp

if TYPE_CHECKING:
    from teleopctl.node import Node

_Snapshot = tuple[
    int, TrajectoryPoint, TrajectoryPoint, TrajectoryPoint, dict[str, list[float]], float
]
# Interface name to field of JointTrajectoryPoint.
_FIELDS = {
    "position": "positions",
    "velocity": "velocities",
    "acceleration": "accelerations",
    "effort": "effort",
}


class TrajectoryStatePublisher:
    """Realtime publisher of ``~/controller_state`` of a joint trajectory controller.

    Args:
        node: Node of the controller.
        publish_queue: Publish queue of the control loop.
        settings: Settings of the controller.
    """

    def __init__(
        self, node: Node, publish_queue: PublishQueue, settings: TrajectorySettings
    ) -> None:
        from teleopctl.interfaces import get_message

        self._node = node
        kind: Any = get_message("control_msgs/msg/JointTrajectoryControllerState")
        # The message is created once and reused.
        self._message: Any = kind(joint_names=list(settings.joints))
        self._publisher = node.create_publisher(kind, "~/controller_state", 10)
        self._realtime_publisher = RealtimePublisher(publish_queue, self._publish)

    def close(self) -> None:
        """Destroy the publisher of ``~/controller_state``."""
        self._node.destroy_publisher(self._publisher)

    @property
    def has_subscribers(self) -> bool:
        """Whether ``~/controller_state`` has subscribers; for use by the control cycle."""
        return bool(self._publisher.has_subscribers)

    def try_publish(
        self,
        time_ns: int,
        reference: TrajectoryPoint,
        feedback: TrajectoryPoint,
        error: TrajectoryPoint,
        output: dict[str, list[float]],
        scaling: float,
    ) -> None:
        """Queue a state message of one update for publishing after the control cycle.

        Args:
            time_ns: Time of the update.
            reference: Desired state.
            feedback: Measured state.
            error: Desired minus measured state.
            output: Values on the command interfaces, by interface name.
            scaling: Speed scaling factor.
        """
        self._realtime_publisher.try_publish((time_ns, reference, feedback, error, output, scaling))

    def _publish(self, snapshot: _Snapshot) -> None:
        time_ns, reference, feedback, error, output, scaling = snapshot
        message = self._message
        stamp = message.header.stamp
        set_stamp(stamp, time_ns)
        reference.copy_to(message.reference)
        feedback.copy_to(message.feedback)
        error.copy_to(message.error)
        for name, values in output.items():
            setattr(message.output, _FIELDS[name], values)
        message.speed_scaling_factor = scaling
        self._publisher.publish(message)

"""``~/controller_state``: what a trajectory controller wants, measures and commands."""

from __future__ import annotations

from typing import Any

from teleopctl.control.outbox import Outbox
from teleopctl.control.trajectory.points import NANOSECONDS, TrajectoryPoint
from teleopctl.control.trajectory.settings import Settings

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
    """Publishes control_msgs/JointTrajectoryControllerState for every update.

    Args:
        node: The controller's node.
        outbox: Where messages leave the control loop.
        settings: The controller's parameters.
    """

    def __init__(self, node: Any, outbox: Outbox, settings: Settings) -> None:
        from teleopctl.interfaces.store import get_message

        self._node = node
        self._state: Any = get_message("control_msgs/msg/JointTrajectoryControllerState")
        self._point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
        self._time: Any = get_message("builtin_interfaces/msg/Time")
        self._duration: Any = get_message("builtin_interfaces/msg/Duration")
        self._joints = list(settings.joints)
        self._publisher = node.create_publisher(self._state, "~/controller_state", 10)
        self._channel = outbox.channel(self._publish)

    def close(self) -> None:
        """Remove the publisher."""
        self._node.destroy_publisher(self._publisher)

    def offer(
        self,
        time_ns: int,
        reference: TrajectoryPoint,
        feedback: TrajectoryPoint,
        error: TrajectoryPoint,
        output: dict[str, list[float]],
        scaling: float,
    ) -> None:
        """Hand the values of one update over.

        Args:
            time_ns: Time of the update.
            reference: What is desired now.
            feedback: What is measured.
            error: The difference.
            output: Values on the command interfaces, by interface name.
            scaling: Speed scaling factor.
        """
        self._channel.offer((time_ns, reference, feedback, error, output, scaling))

    def _publish(self, snapshot: _Snapshot) -> None:
        if not self._publisher.get_subscription_count():
            return
        time_ns, reference, feedback, error, output, scaling = snapshot
        sec, nanosec = divmod(time_ns, NANOSECONDS)
        message = self._state(
            joint_names=self._joints,
            reference=self._to_message(reference),
            feedback=self._to_message(feedback),
            error=self._to_message(error),
            output=self._point(**{_FIELDS[name]: values for name, values in output.items()}),
            speed_scaling_factor=scaling,
        )
        message.header.stamp = self._time(sec=sec, nanosec=nanosec)
        self._publisher.publish(message)

    def _to_message(self, point: TrajectoryPoint) -> Any:
        sec, nanosec = divmod(point.time_ns, NANOSECONDS)
        return self._point(
            positions=point.positions,
            velocities=point.velocities,
            accelerations=point.accelerations,
            effort=point.effort,
            time_from_start=self._duration(sec=sec, nanosec=nanosec),
        )

"""Broadcaster of a measured pose, as topic and transform."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher, realtime_log
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_message, set_stamp

_INTERFACES = tuple(
    f"{part}.{axis}"
    for part, axes in (("position", "xyz"), ("orientation", "xyzw"))
    for axis in axes
)
# Tolerance of the square of a quaternion's length, as in ROS 2.
_TOLERANCE = 0.01


class PoseBroadcaster(ControllerInterface):
    """Controller that publishes a pose from state interfaces, as topic and transform.

    Plug-in type ``pose_broadcaster/PoseBroadcaster``.

    Publishes the pose of ``pose_name`` in ``frame_id`` in each update, and, unless ``tf.enable`` is
    false, as a transform to ``tf.child_frame_id``, which is ``pose_name`` by default. An invalid
    pose (NaN, or no unit quaternion) is not published as a transform.
    """

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the publishers of ``~/pose`` and, if enabled, ``/tf``."""
        read = self.auto_declare
        frame, self._pose_name = read("frame_id", ""), read("pose_name", "")
        for name, value in (("frame_id", frame), ("pose_name", self._pose_name)):
            if not value:
                self.logger.error(f"Parameter '{name}' cannot be empty")
                return CallbackReturn.ERROR
        rate = read("tf.publish_rate", 0.0)
        if not 0.0 <= rate < math.inf:
            self.logger.error(
                f"Parameter 'tf.publish_rate' with the value {rate:g} must be greater than or "
                "equal to 0"
            )
            return CallbackReturn.ERROR
        if rate:
            self.logger.warning(
                "[deprecated] tf.publish_rate parameter is deprecated, please set the value to "
                "0.0. The publish rate of TF messages should not be limited."
            )
        self._period_ns = round(NANOSECONDS_PER_SECOND / rate) if rate else 0
        # Messages are created once and reused. Any: their classes are generated at run time.
        pose: Any = get_message("geometry_msgs/msg/PoseStamped")
        self._pose: Any = pose()
        self._transform: Any = get_message("geometry_msgs/msg/TransformStamped")()
        self._pose.header.frame_id = self._transform.header.frame_id = frame
        self._transform.child_frame_id = read("tf.child_frame_id", "") or self._pose_name
        node = self.get_node()
        self._publisher = node.create_publisher(pose, "~/pose", 10)
        self._transforms: Any = None
        if read("tf.enable", True):
            kind: Any = get_message("tf2_msgs/msg/TFMessage")
            self._message: Any = kind(transforms=[self._transform])
            self._transforms = node.create_publisher(kind, "/tf", 10)
        self._realtime = RealtimePublisher(self.params.publish_queue, self._publish)
        self._log = realtime_log(self.params.publish_queue)
        return None

    def on_cleanup(self) -> None:
        """Destroy the publishers of the pose and the transform."""
        node = self.get_node()
        node.destroy_publisher(self._publisher)
        if self._transforms is not None:
            node.destroy_publisher(self._transforms)

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the pose's three position and four orientation state interfaces."""
        names = [f"{self._pose_name}/{interface}" for interface in _INTERFACES]
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def on_activate(self) -> None:
        """Reset the time of the last transform, so that the next update publishes one."""
        self._last_ns: int | None = None
        self._logged_ns: int | None = None

    def on_restart(self) -> None:
        """Reset the time of the last transform after a simulation reset."""
        self.on_activate()

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Queue the measured pose for publishing; if valid and due, also as transform."""
        del period
        values = [state.value for state in self.state_interfaces]
        valid = all(map(math.isfinite, values)) and (
            abs(sum(value * value for value in values[3:]) - 1.0) <= _TOLERANCE
        )
        if not valid:
            self._log_invalid(time_ns, values)
        due = self._last_ns is None or time_ns - self._last_ns >= self._period_ns
        if valid and due:
            self._last_ns = time_ns
        self._realtime.try_publish((time_ns, values, valid and due))
        return None

    def _log_invalid(self, time_ns: int, values: Sequence[float]) -> None:
        if self._logged_ns is not None and time_ns - self._logged_ns < NANOSECONDS_PER_SECOND:
            return
        self._logged_ns = time_ns
        position, orientation = (
            ", ".join(f"{value:f}" for value in part) for part in (values[:3], values[3:])
        )
        self._log.try_publish((self.logger.error, f"Invalid pose [{position}], [{orientation}]"))

    def _publish(self, value: tuple[int, Sequence[float], bool]) -> None:
        time_ns, values, as_transform = value
        pose, transform = self._pose.pose, self._transform.transform
        for point in (pose.position, transform.translation):
            point.x, point.y, point.z = values[:3]
        for turn in (pose.orientation, transform.rotation):
            turn.x, turn.y, turn.z, turn.w = values[3:]
        for header in (self._pose.header, self._transform.header):
            set_stamp(header.stamp, time_ns)
        self._publisher.publish(self._pose)
        if as_transform and self._transforms is not None:
            self._transforms.publish(self._message)

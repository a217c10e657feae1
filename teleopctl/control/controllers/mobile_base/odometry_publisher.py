"""Publisher of a mobile base's odometry and transform."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_message, set_stamp

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface
    from teleopctl.control.controllers.mobile_base.odometry import Odometry

# Rows of a 6 by 6 covariance.
_ROWS = 6


class OdometryPublisher:
    """Realtime publisher of odometry and transform, at a rate by the controller's time.

    Reads the controller's parameters ``odom_frame_id``, ``base_frame_id``, ``tf_frame_prefix``
    and ``tf_frame_prefix_enable``, ``enable_odom_tf`` and the covariances' diagonals.

    Args:
        controller: Controller of the base.
        topic: Topic of the odometry.
        transform_topic: Topic of the transform.
        publish_rate: Publishing rate in Hz; 0 to publish in every update.
        covariance_parameters: Parameters of the diagonals of pose and twist covariance, six values
            each.
    """

    def __init__(
        self,
        controller: ControllerInterface,
        topic: str,
        transform_topic: str,
        publish_rate: float,
        covariance_parameters: tuple[str, str],
    ) -> None:
        self._node = node = controller.get_node()
        read = controller.auto_declare
        prefix = _prefix(controller)
        odometry = get_message("nav_msgs/msg/Odometry")
        transforms = get_message("tf2_msgs/msg/TFMessage")
        # Messages are created once and reused.
        # Any: message classes are generated at run time.
        self._message: Any = odometry()
        self._message.header.frame_id = prefix + read("odom_frame_id", "odom")
        self._message.child_frame_id = prefix + read("base_frame_id", "base_link")
        for field, parameter in zip(("pose", "twist"), covariance_parameters, strict=True):
            diagonal: list[float] = read(parameter, [0.0] * _ROWS)
            covariance = [0.0] * _ROWS**2
            for row, value in enumerate(diagonal):
                covariance[row * (_ROWS + 1)] = float(value)
            getattr(self._message, field).covariance = covariance
        self._transform: Any = get_message("geometry_msgs/msg/TransformStamped")()
        self._transform.header.frame_id = self._message.header.frame_id
        self._transform.child_frame_id = self._message.child_frame_id
        self._transforms: Any = transforms(transforms=[self._transform])
        self._publishers = [node.create_publisher(odometry, topic, 10)]
        if read("enable_odom_tf", True):
            self._publishers.append(node.create_publisher(transforms, transform_topic, 10))
        self._realtime_publisher = RealtimePublisher(controller.params.publish_queue, self._publish)
        self._period_ns = round(NANOSECONDS_PER_SECOND / publish_rate) if publish_rate > 0.0 else 0
        self.restart()

    def close(self) -> None:
        """Destroy the publishers of odometry and transform."""
        for publisher in self._publishers:
            self._node.destroy_publisher(publisher)

    def restart(self) -> None:
        """Make the next `try_publish` publish, whatever the time since the last publication."""
        self._due_ns = 0

    def try_publish(self, time_ns: int, odometry: Odometry) -> None:
        """Queue odometry and transform for publishing if the publish period has passed."""
        if time_ns < self._due_ns:
            return
        # Keeps the mean rate, even if the rate is no divisor of the controller's rate.
        late = time_ns - self._due_ns
        self._due_ns = (self._due_ns if late < self._period_ns else time_ns) + self._period_ns
        self._realtime_publisher.try_publish(
            (
                time_ns,
                (odometry.x, odometry.y, odometry.heading),
                (odometry.linear_x, odometry.linear_y, odometry.angular),
            )
        )

    def _publish(
        self, value: tuple[int, tuple[float, float, float], tuple[float, float, float]]
    ) -> None:
        time_ns, (x, y, heading), twist = value
        cosine, sine = math.cos(heading / 2.0), math.sin(heading / 2.0)
        pose, transform = self._message.pose.pose, self._transform.transform
        for point in (pose.position, transform.translation):
            point.x, point.y = x, y
        for turn in (pose.orientation, transform.rotation):
            turn.z, turn.w = sine, cosine
        speed = self._message.twist.twist
        speed.linear.x, speed.linear.y, speed.angular.z = twist
        set_stamp(self._message.header.stamp, time_ns)
        set_stamp(self._transform.header.stamp, time_ns)
        for publisher, message in zip(
            self._publishers, (self._message, self._transforms), strict=False
        ):
            publisher.publish(message)


def _prefix(controller: ControllerInterface) -> str:
    """Return the prefix of both frames: a parameter, else the namespace."""
    read = controller.auto_declare
    if not read("tf_frame_prefix_enable", True):
        return ""
    prefix = read("tf_frame_prefix", "") or controller.get_node().get_namespace()
    prefix = prefix.strip("/")
    return f"{prefix}/" if prefix else ""

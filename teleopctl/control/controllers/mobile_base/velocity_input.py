"""Velocity commands of a mobile base, received from a topic."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.control.realtime_publisher import realtime_log
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_message, to_nanoseconds, to_seconds

if TYPE_CHECKING:
    from teleopctl.control.controllers.base import ControllerInterface
    from teleopctl.node import MessageInfo


class BaseVelocity(NamedTuple):
    """Velocity of a mobile base in its own frame: forwards, to the left, and turn rate.

    Attributes:
        x: Velocity forwards, m/s.
        y: Velocity to the left, m/s.
        angular: Angular velocity, counterclockwise, rad/s.
    """

    x: float = 0.0
    y: float = 0.0
    angular: float = 0.0


_REST = BaseVelocity()


class VelocityInput:
    """Subscription to velocity commands of a mobile base, which are valid until a timeout.

    Args:
        controller: Controller of the base.
        topic: Topic of TwistStamped messages.
        unstamped_topic: Topic of Twist messages, used if parameter ``use_stamped_vel`` is false.
        timeout: Seconds for which a velocity is valid; 0 for no timeout.

    Attributes:
        active: Whether the controller is active; otherwise messages are ignored.
    """

    def __init__(
        self, controller: ControllerInterface, topic: str, unstamped_topic: str, timeout: float
    ) -> None:
        self.active = False
        self._latest: tuple[int, BaseVelocity] | None = None
        self._node = node = controller.get_node()
        self._controller = controller
        self._logger = controller.logger
        self._now_ns = controller.params.now_ns
        self._timeout_ns = round(timeout * NANOSECONDS_PER_SECOND)
        self._log = realtime_log(controller.params.publish_queue)
        self._warned_about_stamp = False
        if controller.auto_declare("use_stamped_vel", True):
            self._subscription = node.create_subscription(
                get_message("geometry_msgs/msg/TwistStamped"), topic, self._stamped, 10
            )
        else:
            self._subscription = node.create_subscription(
                get_message("geometry_msgs/msg/Twist"), unstamped_topic, self._unstamped, 10
            )

    def close(self) -> None:
        """Destroy the subscription to velocity commands."""
        self._node.destroy_subscription(self._subscription)

    @property
    def latest(self) -> tuple[int, BaseVelocity] | None:
        """Last received velocity with its time in nanoseconds; None if there is none."""
        return self._latest

    @latest.setter
    def latest(self, latest: tuple[int, BaseVelocity] | None) -> None:
        self._latest = latest

    def clear(self) -> None:
        """Discard the last received velocity command."""
        self._latest = None

    def read(self, time_ns: int) -> BaseVelocity:
        """Return the last velocity command at a time; zero without one or after its timeout."""
        latest = self._latest
        if latest is None:
            return _REST
        stamp_ns, velocity = latest
        if self._timeout_ns and time_ns - stamp_ns > self._timeout_ns:
            self.clear()
            if velocity != _REST:
                self._log.try_publish(
                    (self._logger.warning, "Velocity command timed out. Braking.")
                )
            return _REST
        return velocity

    # Any: message classes are generated at run time.
    def _stamped(self, message: Any, info: MessageInfo) -> None:
        stamp_ns, now_ns = to_nanoseconds(message.header.stamp), self._now_ns()
        if stamp_ns == 0:
            if not self._warned_about_stamp:
                self._warned_about_stamp = True
                self._logger.warning(
                    "Received TwistStamped with zero timestamp, setting it to current time, this "
                    "message will only be shown once"
                )
            stamp_ns = now_ns
        age_ns = now_ns - stamp_ns
        if self._timeout_ns and age_ns >= self._timeout_ns:
            self._logger.warning(
                f"Ignoring the received message (timestamp {to_seconds(stamp_ns):.10f}) because it "
                f"is older than the current time by {to_seconds(age_ns):.10f} seconds, which "
                f"exceeds the allowed timeout ({to_seconds(self._timeout_ns):.4f})",
                throttle_duration_sec=1.0,
            )
            return
        # A stamp in the future, perhaps of another clock, must not extend the timeout.
        self._take(message.twist, min(stamp_ns, now_ns), info["publisher_gid"])

    def _unstamped(self, message: Any, info: MessageInfo) -> None:
        self._take(message, self._now_ns(), info["publisher_gid"])

    def _take(self, twist: Any, stamp_ns: int, sender: bytes) -> None:
        if not self.active:
            self._logger.warning(
                "Can't accept new commands. subscriber is inactive", throttle_duration_sec=1.0
            )
            return
        if self._controller.is_refused("The velocity command", sender):
            return
        velocity = BaseVelocity(twist.linear.x, twist.linear.y, twist.angular.z)
        if not all(map(math.isfinite, velocity)):
            self._logger.warning(
                "Command message contains NaNs: it is ignored.", throttle_duration_sec=1.0
            )
            return
        self._latest = (stamp_ns, velocity)

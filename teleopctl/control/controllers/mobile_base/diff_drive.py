"""Controller of differential drive bases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from teleopctl.control.controllers.mobile_base.base import ChainableBase, InvalidBaseError
from teleopctl.control.controllers.mobile_base.rate_limiter import RateLimiter, read_limits
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity
from teleopctl.control.handles import POSITION, VELOCITY
from teleopctl.control.lifecycle import CallbackReturn
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.interfaces import get_message, set_stamp


class DiffDriveController(ChainableBase):
    """Controller of a base with driven left and right wheels: turns velocity into wheel speeds.

    Plug-in type ``diff_drive_controller/DiffDriveController``.

    At speed v and turn rate w the wheels, L apart with radius r, turn with ``(v - w L/2) / r`` on
    the left and ``(v + w L/2) / r`` on the right.
    """

    def read_parameters(self) -> None:
        """Read and check the parameters of wheels, geometry and limits."""
        read = self.auto_declare
        no_names: list[str] = []
        self._left: list[str] = read("left_wheel_names", no_names)
        self._right: list[str] = read("right_wheel_names", no_names)
        if not self._left or not self._right:
            raise InvalidBaseError(
                "Parameters 'left_wheel_names' and 'right_wheel_names' must not be empty"
            )
        if len(self._left) != len(self._right):
            raise InvalidBaseError(
                f"The number of left wheels [{len(self._left)}] and the number of right wheels "
                f"[{len(self._right)}] are different"
            )
        radius, separation = read("wheel_radius", 0.0), read("wheel_separation", 0.0)
        for name, value in (("wheel_radius", radius), ("wheel_separation", separation)):
            if value <= 0.0:
                raise InvalidBaseError(f"Parameter '{name}' is {value:g}: it must be above 0")
        self._separation = separation * read("wheel_separation_multiplier", 1.0)
        self._left_radius = radius * read("left_wheel_radius_multiplier", 1.0)
        self._right_radius = radius * read("right_wheel_radius_multiplier", 1.0)
        try:
            self._linear = RateLimiter(read_limits(self, "linear.x"))
            self._angular = RateLimiter(read_limits(self, "angular.z"))
        except ValueError as error:
            raise InvalidBaseError(str(error)) from None
        self._by_position = self.feedback_type == POSITION

    def command_names(self) -> Sequence[str]:
        """Return the velocity interfaces of the left wheels, then of the right ones."""
        return [f"{wheel}/{VELOCITY}" for wheel in (*self._left, *self._right)]

    def feedback_names(self) -> Sequence[str]:
        """Return the state interfaces of the left wheels, then of the right ones."""
        return [f"{wheel}/{self.feedback_type}" for wheel in (*self._left, *self._right)]

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the topics, with ``~/cmd_vel_out`` if configured."""
        outcome = super().on_configure()
        self._limited: Any = None
        if outcome is None and self.auto_declare("publish_limited_velocity", False):
            # Any: message classes are generated at run time.
            kind: Any = get_message("geometry_msgs/msg/TwistStamped")
            self._limited_message: Any = kind()
            self._limited = self.get_node().create_publisher(kind, "~/cmd_vel_out", 10)
            self._realtime_limited = RealtimePublisher(
                self.params.publish_queue, self._publish_limited
            )
        return outcome

    def on_cleanup(self) -> None:
        """Destroy the subscription and the publishers."""
        super().on_cleanup()
        if self._limited is not None:
            self.get_node().destroy_publisher(self._limited)

    def on_activate(self) -> None:
        """Discard earlier velocity commands, and reset the limiters to begin at speed zero."""
        super().on_activate()
        self._linear.reset()
        self._angular.reset()

    def limit(self, velocity: BaseVelocity, period: float) -> BaseVelocity:
        """Return a requested velocity limited in speed, acceleration and jerk."""
        return BaseVelocity(
            self._linear.limit(velocity.x, period),
            angular=self._angular.limit(velocity.angular, period),
        )

    def displacement(
        self, values: Sequence[float], last_values: Sequence[float], period: float
    ) -> BaseVelocity:
        """Return the base's displacement (m, m, rad) by the mean of the wheels on each side."""
        if self._by_position:
            turned = [now - before for now, before in zip(values, last_values, strict=True)]
        else:
            turned = [speed * period for speed in values]
        count = len(self._left)
        left = sum(turned[:count]) / count * self._left_radius
        right = sum(turned[count:]) / count * self._right_radius
        return BaseVelocity((left + right) / 2.0, angular=(right - left) / self._separation)

    def wheel_commands(self, velocity: BaseVelocity) -> Sequence[float]:
        """Return the velocities of left, then right wheels (rad/s) for a base velocity."""
        half = velocity.angular * self._separation / 2.0
        left = (velocity.x - half) / self._left_radius
        right = (velocity.x + half) / self._right_radius
        return [left] * len(self._left) + [right] * len(self._right)

    def on_commanded(self, time_ns: int, velocity: BaseVelocity) -> None:
        """Queue the limited velocity for ``~/cmd_vel_out``, if configured."""
        if self._limited is not None:
            self._realtime_limited.try_publish((time_ns, velocity))

    def _publish_limited(self, value: tuple[int, BaseVelocity]) -> None:
        time_ns, velocity = value
        message = self._limited_message
        set_stamp(message.header.stamp, time_ns)
        message.twist.linear.x, message.twist.angular.z = velocity.x, velocity.angular
        self._limited.publish(message)

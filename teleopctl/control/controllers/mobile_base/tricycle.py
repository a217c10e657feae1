"""Controller of bases with one wheel that both drives and steers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from teleopctl.control.controllers.mobile_base.base import InvalidBaseError, MobileBaseController
from teleopctl.control.controllers.mobile_base.rate_limiter import RateLimiter, RateLimits
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity
from teleopctl.control.handles import POSITION, VELOCITY
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.interfaces import get_service

# Parameters of ROS 2's controller that have no effect here.
_UNSUPPORTED = ("publish_ackermann_command", "odom_only_twist")
# Beyond the first error of the steering angle (rad) the wheel drives slower, beyond the second with
# the third as factor.
_NEAR, _FAR, _CRAWL = math.pi / 6.0, math.pi / 2.0, 0.01


class TricycleController(MobileBaseController):
    """Controller of a base with one wheel that both drives and steers.

    Plug-in type ``tricycle_controller/TricycleController``.

    The wheel is a wheelbase L in front of the base frame's origin. For speed v and turn rate w its
    steering angle is ``a = atan(w L / v)`` and its speed ``v / cos(a)``; the base can turn on the
    spot.
    """

    unstamped_topic = "~/cmd_vel"
    default_publish_rate = 0.0

    def on_init(self) -> None:
        """Declare the parameters of mobile bases, with ``enable_odom_tf`` false by default."""
        super().on_init()
        self.auto_declare("enable_odom_tf", False)

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the topics and the service ``~/reset_odometry``."""
        outcome = super().on_configure()
        self._resets = False
        if outcome is None:
            self._service = self.get_node().create_service(
                get_service("std_srvs/srv/Empty"), "~/reset_odometry", self._reset_odometry
            )
        return outcome

    def on_cleanup(self) -> None:
        """Destroy the subscription, the publishers and the reset service."""
        super().on_cleanup()
        self.get_node().destroy_service(self._service)

    # Any: classes of requests and responses are generated at run time.
    def _reset_odometry(self, request: Any, response: Any) -> Any:
        del request
        self._resets = True
        return response

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Reset the odometry if the service requested that; then command the wheel as usual."""
        if self._resets:
            self._resets = False
            self._odometry.reset()
        return super().update(time_ns, period)

    def read_timeout(self) -> float:
        """Return the velocity command timeout in seconds, from a parameter in milliseconds."""
        return self.auto_declare("cmd_vel_timeout", 500) / 1000.0

    def read_parameters(self) -> None:
        """Read and check the parameters of joints, geometry and limits."""
        read = self.auto_declare
        self._traction, self._steering = (
            read(name, "") for name in ("traction_joint_name", "steering_joint_name")
        )
        self._wheelbase, self._radius = read("wheelbase", 0.0), read("wheel_radius", 0.0)
        if not (self._traction and self._steering):
            raise InvalidBaseError(
                "Parameters 'traction_joint_name' and 'steering_joint_name' must not be empty"
            )
        if self._wheelbase <= 0.0 or self._radius <= 0.0:
            raise InvalidBaseError("Parameters 'wheelbase' and 'wheel_radius' must be above 0")
        for name in _UNSUPPORTED:
            if read(name, False):
                self.logger.warning(f"Parameter '{name}' is not supported and has no effect.")
        speed, acceleration, braking, jerk = (
            self._limit(f"traction.max_{name}")
            for name in ("velocity", "acceleration", "deceleration", "jerk")
        )
        self._speed_limiter = _limiter(speed, acceleration, braking, jerk)
        turning, swinging = (
            self._limit(f"steering.max_{name}") for name in ("velocity", "acceleration")
        )
        # ROS 2's limit on the acceleration of the angle is twice as large as the parameter.
        self._angle_limiter = _limiter(math.inf, turning, turning, 2.0 * swinging)
        self._furthest = (
            read("steering.min_position", math.nan),
            read("steering.max_position", math.nan),
        )
        self._period = self.nominal_period

    def _limit(self, name: str) -> float:
        value = self.auto_declare(name, math.nan)
        if value < 0.0:
            raise InvalidBaseError(f"Parameter '{name}' cannot be negative: it counts both ways")
        return math.inf if math.isnan(value) else value

    def command_names(self) -> Sequence[str]:
        """Return the traction joint's velocity and the steering joint's position interface."""
        return [f"{self._traction}/{VELOCITY}", f"{self._steering}/{POSITION}"]

    feedback_names = command_names

    def on_activate(self) -> None:
        """Discard earlier velocity commands; reset the limiters and the steering angle."""
        super().on_activate()
        self._speed_limiter.reset()
        self._angle_limiter.reset()
        self._angle = 0.0

    def on_deactivate(self) -> None:
        """Command the wheel to stop at once, without limiting the deceleration."""
        self._speed_limiter.reset()
        super().on_deactivate()

    def limit(self, velocity: BaseVelocity, period: float) -> BaseVelocity:
        """Return the requested velocity unchanged; `wheel_commands` limits the wheel instead."""
        self._period = period
        return velocity

    def displacement(
        self, values: Sequence[float], last_values: Sequence[float], period: float
    ) -> BaseVelocity:
        """Return the base's displacement (m, m, rad) by the wheel's speed and angle."""
        del last_values
        rolled = values[0] * period * self._radius
        return BaseVelocity(
            rolled * math.cos(values[1]), angular=rolled * math.sin(values[1]) / self._wheelbase
        )

    def wheel_commands(self, velocity: BaseVelocity) -> Sequence[float]:
        """Return the limited wheel velocity (rad/s) and steering angle (rad)."""
        sideways = velocity.angular * self._wheelbase
        if velocity.x != 0.0 or sideways != 0.0:
            backwards = velocity.x < 0.0
            self._angle = math.atan2(-sideways if backwards else sideways, abs(velocity.x))
        speed = math.copysign(math.hypot(velocity.x, sideways), velocity.x) / self._radius
        if velocity.x == 0.0:
            speed = abs(speed)
        measured = self.state_interfaces[1].value if self.state_interfaces else self._angle
        speed *= _slowed(abs(self._angle - measured)) if math.isfinite(measured) else 1.0
        lowest, highest = self._furthest
        angle = self._angle_limiter.limit(self._angle, self._period)
        # Comparisons with NaN are false: no limit.
        angle = highest if angle > highest else lowest if angle < lowest else angle
        return [self._speed_limiter.limit(speed, self._period), angle]


def _slowed(away: float) -> float:
    """Return the factor on a wheel's speed for an error of its steering angle (rad)."""
    if away < _NEAR:
        return 1.0
    return _CRAWL if away > _FAR else math.cos(away)


def _limiter(highest: float, faster: float, slower: float, jerk: float) -> RateLimiter:
    """Return a limiter with the same limits in both directions."""
    return RateLimiter(RateLimits(-highest, highest, faster, -slower, -faster, slower, -jerk, jerk))

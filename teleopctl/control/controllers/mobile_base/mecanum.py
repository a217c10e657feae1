"""Controller of bases on four mecanum wheels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from teleopctl.control.controllers.mobile_base.base import ChainableBase, InvalidBaseError
from teleopctl.control.controllers.mobile_base.rate_limiter import RateLimiter, read_limits
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity
from teleopctl.control.handles import VELOCITY
from teleopctl.control.lifecycle import CallbackReturn
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.interfaces import get_message, set_stamp

_WHEELS = ("front_left", "front_right", "rear_right", "rear_left")
# Signs of the parts that sideways motion and turning add to each wheel.
_SIDEWAYS = (-1.0, 1.0, -1.0, 1.0)
_TURNING = (-1.0, 1.0, 1.0, -1.0)


class MecanumDriveController(ChainableBase):
    """Controller of a base on four mecanum wheels, which turns velocity into wheel speeds.

    Plug-in type ``mecanum_drive_controller/MecanumDriveController``.

    Wheels of radius r turn with ``(x ∓ y ∓ s w) / r``, where s is the sum of the distances from the
    centre to a wheel along x and along y.
    """

    command_topic = "~/reference"
    unstamped_topic = "~/reference_unstamped"
    odometry_topic = "~/odometry"
    transform_topic = "~/tf_odometry"
    timeout_parameter = "reference_timeout"
    default_timeout = 0.0
    default_publish_rate = 0.0
    references = ("linear/x", "linear/y", "angular/z")

    def read_parameters(self) -> None:
        """Read and check the parameters of wheels, geometry and limits."""
        read = self.auto_declare
        self._joints = [read(f"{wheel}_wheel_command_joint_name", "") for wheel in _WHEELS]
        for wheel, joint in zip(_WHEELS, self._joints, strict=True):
            if not joint:
                raise InvalidBaseError(
                    f"Parameter '{wheel}_wheel_command_joint_name' must not be empty"
                )
        states = (read(f"{wheel}_wheel_state_joint_name", "") for wheel in _WHEELS)
        self._states = [state or joint for state, joint in zip(states, self._joints, strict=True)]
        self._radius = read("kinematics.wheels_radius", 0.0)
        self._reach = read("kinematics.sum_of_robot_center_projection_on_X_Y_axis", 0.0)
        for name, value in (
            ("wheels_radius", self._radius),
            ("sum_of_robot_center_projection_on_X_Y_axis", self._reach),
        ):
            if value <= 0.0:
                raise InvalidBaseError(f"Parameter 'kinematics.{name}' must be above 0")
        if any(read(f"kinematics.base_frame_offset.{name}", 0.0) for name in ("x", "y", "theta")):
            raise InvalidBaseError(
                "Parameter 'kinematics.base_frame_offset' is not supported: the base frame is in "
                "the middle of the wheels"
            )
        try:
            self._limiters = [
                RateLimiter(read_limits(self, name))
                for name in ("linear.x", "linear.y", "angular.z")
            ]
        except ValueError as error:
            raise InvalidBaseError(str(error)) from None

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the topics, with ``~/controller_state``."""
        outcome = super().on_configure()
        if outcome is None:
            # Any: message classes are generated at run time. The message is reused.
            kind: Any = get_message("control_msgs/msg/MecanumDriveControllerState")
            self._state_message: Any = kind()
            self._state_publisher = self.get_node().create_publisher(kind, "~/controller_state", 10)
            self._realtime_state = RealtimePublisher(self.params.publish_queue, self._publish_state)
        return outcome

    def on_cleanup(self) -> None:
        """Destroy the subscription and the publishers."""
        super().on_cleanup()
        self.get_node().destroy_publisher(self._state_publisher)

    def on_commanded(self, time_ns: int, velocity: BaseVelocity) -> None:
        """Queue the measured wheel and commanded velocities for ``~/controller_state``."""
        speeds = [state.value for state in self.state_interfaces]
        self._realtime_state.try_publish((time_ns, speeds, velocity))

    def _publish_state(self, value: tuple[int, Sequence[float], BaseVelocity]) -> None:
        time_ns, speeds, velocity = value
        message = self._state_message
        set_stamp(message.header.stamp, time_ns)
        # In open loop there are no measured speeds.
        for wheel, speed in zip(_WHEELS, speeds or [math.nan] * len(_WHEELS), strict=True):
            setattr(message, f"{wheel.replace('rear', 'back')}_wheel_velocity", speed)
        twist = message.reference_velocity
        twist.linear.x, twist.linear.y, twist.angular.z = velocity
        self._state_publisher.publish(message)

    def on_activate(self) -> None:
        """Discard earlier velocity commands, and reset the limiters to begin at speed zero."""
        super().on_activate()
        for limiter in self._limiters:
            limiter.reset()

    def command_names(self) -> Sequence[str]:
        """Return the wheels' command interfaces: front left, front right, rear right, rear left."""
        return [f"{joint}/{VELOCITY}" for joint in self._joints]

    def feedback_names(self) -> Sequence[str]:
        """Return the wheels' velocity state interfaces, in the order of `command_names`."""
        return [f"{joint}/{VELOCITY}" for joint in self._states]

    def limit(self, velocity: BaseVelocity, period: float) -> BaseVelocity:
        """Return a velocity limited in x, y and yaw: speed, acceleration and jerk."""
        return BaseVelocity(
            *(
                limiter.limit(value, period)
                for limiter, value in zip(self._limiters, velocity, strict=True)
            )
        )

    def displacement(
        self, values: Sequence[float], last_values: Sequence[float], period: float
    ) -> BaseVelocity:
        """Return the base's displacement (m, m, rad) by the speeds of the four wheels."""
        del last_values
        step = self._radius * period / len(values)
        return BaseVelocity(
            sum(values) * step,
            sum(sign * value for sign, value in zip(_SIDEWAYS, values, strict=True)) * step,
            sum(sign * value for sign, value in zip(_TURNING, values, strict=True))
            * step
            / self._reach,
        )

    def wheel_commands(self, velocity: BaseVelocity) -> Sequence[float]:
        """Return the four wheel velocities (rad/s) for a velocity of the base."""
        turn = velocity.angular * self._reach
        return [
            (velocity.x + sideways * velocity.y + turning * turn) / self._radius
            for sideways, turning in zip(_SIDEWAYS, _TURNING, strict=True)
        ]

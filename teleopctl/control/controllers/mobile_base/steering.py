"""Controllers of bases that steer some wheels and drive others.

The origin of the base frame is the middle of the driven axle. For speed v and turn rate w, a base
with wheelbase L steers the middle of the steered axle by ``atan(w L / v)``; all wheels roll on
circles about one centre.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from teleopctl.control.controllers.mobile_base.base import ChainableBase, InvalidBaseError
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity
from teleopctl.control.handles import POSITION, VELOCITY


class _SteeringController(ChainableBase):
    """Common base of steering controllers; pairs of joints are right before left."""

    command_topic = "~/reference"
    unstamped_topic = "~/reference_unstamped"
    odometry_topic = "~/odometry"
    transform_topic = "~/tf_odometry"
    timeout_parameter = "reference_timeout"
    default_timeout = 1.0
    default_publish_rate = 0.0
    driven_wheels: ClassVar[int] = 2
    steered_wheels: ClassVar[int] = 1

    def read_parameters(self) -> None:
        """Read and check the parameters of wheels and geometry, by new or older names."""
        front = self.auto_declare("front_steering", True)
        driven, steered = ("rear", "front") if front else ("front", "rear")
        self._driven = self._joints("traction_joints_names", driven, self.driven_wheels)
        self._steered = self._joints("steering_joints_names", steered, self.steered_wheels)
        self._driven_states = self._joints("traction_joints_state_names", driven) or self._driven
        self._steered_states = self._joints("steering_joints_state_names", steered) or self._steered
        self._wheelbase = self._length("wheelbase")
        self._radius = self._length(
            "traction_wheels_radius",
            "traction_wheel_radius",
            f"{driven}_wheels_radius",
            f"{driven}_wheel_radius",
        )
        self._driven_track = self._steered_track = 0.0
        if self.driven_wheels > 1:
            old = f"{driven}_wheel_track" if self.steered_wheels > 1 else "wheel_track"
            self._driven_track = self._length("traction_track_width", old)
        if self.steered_wheels > 1:
            read = self.auto_declare
            track = read("steering_track_width", 0.0) or read(f"{steered}_wheel_track", 0.0)
            self._steered_track = track or self._driven_track
        if self.auto_declare("reduce_wheel_speed_until_steering_reached", False):
            self.logger.warning(
                "Parameter 'reduce_wheel_speed_until_steering_reached' has no effect here"
            )
        self._by_position = self.feedback_type == POSITION
        self._angles = [0.0] * self.steered_wheels

    def _joints(self, name: str, side: str, count: int = 0) -> list[str]:
        """Return the joints named by a parameter, or by the parameter of older files for a side."""
        no_names: list[str] = []
        old = f"{side}_wheels_state_names" if "state" in name else f"{side}_wheels_names"
        names = self.auto_declare(name, no_names) or self.auto_declare(old, no_names)
        if count and len(names) != count:
            raise InvalidBaseError(
                f"Parameter '{name}' names {len(names)} joints, this base has {count}"
            )
        return names

    def _length(self, *names: str) -> float:
        for name in names:
            value = self.auto_declare(name, 0.0)
            if value > 0.0:
                return value
        raise InvalidBaseError(f"Parameter '{names[0]}' must be above 0")

    def command_names(self) -> Sequence[str]:
        """Return velocity interfaces of driven, then position interfaces of steered wheels."""
        return [f"{j}/{VELOCITY}" for j in self._driven] + [
            f"{j}/{POSITION}" for j in self._steered
        ]

    def feedback_names(self) -> Sequence[str]:
        """Return the state interfaces of driven, then of steered wheels."""
        return [f"{joint}/{self.feedback_type}" for joint in self._driven_states] + [
            f"{joint}/{POSITION}" for joint in self._steered_states
        ]

    def on_activate(self) -> None:
        """Discard earlier velocity commands, and set the steering angles to straight."""
        super().on_activate()
        self._angles = [0.0] * self.steered_wheels

    def displacement(
        self, values: Sequence[float], last_values: Sequence[float], period: float
    ) -> BaseVelocity:
        """Return the base's displacement (m, m, rad) by driven and steered wheels."""
        driven = values[: self.driven_wheels]
        if self._by_position:
            turned = sum(now - before for now, before in zip(driven, last_values, strict=False))
        else:
            turned = sum(driven) * period
        forwards = turned / self.driven_wheels * self._radius
        angle = self._middle(values[self.driven_wheels :])
        return BaseVelocity(forwards, angular=forwards * math.tan(angle) / self._wheelbase)

    def _middle(self, angles: Sequence[float]) -> float:
        """Return the mean steering angle at the middle of the steered axle."""
        if len(angles) == 1:
            return angles[0]
        half, length = self._steered_track / 2.0, self._wheelbase
        # Each wheel has its own distance to the centre, half the track from that of the middle.
        return sum(
            math.atan2(length * math.tan(angle), length + side * half * math.tan(angle))
            for angle, side in zip(angles, (-1.0, 1.0), strict=True)
        ) / len(angles)

    def wheel_commands(self, velocity: BaseVelocity) -> Sequence[float]:
        """Return wheel velocities (rad/s), then steering angles (rad), kept for zero velocity."""
        if velocity.x != 0.0 or velocity.angular != 0.0:
            self._angles = self._steering(velocity)
        half = velocity.angular * self._driven_track / 2.0
        speeds = [velocity.x + half, velocity.x - half] if self.driven_wheels > 1 else [velocity.x]
        return [speed / self._radius for speed in speeds] + self._angles

    def _steering(self, velocity: BaseVelocity) -> list[float]:
        """Return the steering angles for the circle of a velocity, right before left."""
        # Backwards, the same circle needs the opposite turn rate.
        forwards = abs(velocity.x)
        sideways = math.copysign(1.0, velocity.x) * velocity.angular * self._wheelbase
        half = velocity.angular * self._steered_track / 2.0 * math.copysign(1.0, velocity.x)
        if self.steered_wheels == 1:
            return [math.atan2(sideways, forwards)]
        return [math.atan2(sideways, forwards + half), math.atan2(sideways, forwards - half)]


class BicycleSteeringController(_SteeringController):
    """Controller of a base with one driven and one steered wheel.

    Plug-in type ``bicycle_steering_controller/BicycleSteeringController``.
    """

    driven_wheels = 1


class TricycleSteeringController(_SteeringController):
    """Controller of a base with two driven wheels and one steered wheel.

    Plug-in type ``tricycle_steering_controller/TricycleSteeringController``.
    """


class AckermannSteeringController(_SteeringController):
    """Controller of a base with two driven and two steered wheels.

    Plug-in type ``ackermann_steering_controller/AckermannSteeringController``.
    """

    steered_wheels = 2

"""Controller of bases on three or more omni wheels in a circle."""

from __future__ import annotations

import math
from collections.abc import Sequence

from teleopctl.control.controllers.mobile_base.base import ChainableBase, InvalidBaseError
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity
from teleopctl.control.handles import POSITION, VELOCITY

_FEWEST_WHEELS = 3


class OmniWheelDriveController(ChainableBase):
    """Controller of a base on omni wheels at equal angles in a circle.

    Plug-in type ``omni_wheel_drive_controller/OmniWheelDriveController``.

    The wheel at angle a, counterclockwise from the x axis, rolls at right angles to its radius. For
    a base velocity (x, y, w), wheels of radius r at the distance R from the centre turn with
    ``(x sin a - y cos a - w R) / r``.
    """

    default_publish_rate = 0.0
    default_window = 1
    covariance_parameters = ("diagonal_covariance.pose", "diagonal_covariance.twist")
    references = ("linear/x", "linear/y", "angular/z")

    def read_parameters(self) -> None:
        """Read and check the parameters of wheels and geometry."""
        read = self.auto_declare
        no_names: list[str] = []
        self._wheels: list[str] = read("wheel_names", no_names)
        count = len(self._wheels)
        if count < _FEWEST_WHEELS:
            raise InvalidBaseError(
                f"The number of wheels is less than 3 ({count} in 'wheel_names'). If there are "
                "more wheels please pass them all to the controller or use a different one for "
                "your wheel configuration."
            )
        offset = read("wheel_offset", math.nan)
        if not math.isfinite(offset):
            raise InvalidBaseError(
                "Parameter 'wheel_offset' has no value: it is the angle (rad) from the x axis to "
                "the first wheel, 0.0 if that wheel is in front"
            )
        self._distance, self._radius = read("robot_radius", 0.0), read("wheel_radius", 0.0)
        for name, value in (("robot_radius", self._distance), ("wheel_radius", self._radius)):
            if not 0.0 < value < math.inf:
                raise InvalidBaseError(f"Parameter '{name}' is {value:g}: it must be above 0")
        angles = [math.tau / count * number + offset for number in range(count)]
        self._directions = [(math.sin(angle), -math.cos(angle)) for angle in angles]
        self._by_position = self.feedback_type == POSITION

    def command_names(self) -> Sequence[str]:
        """Return the velocity interfaces of the wheels."""
        return [f"{wheel}/{VELOCITY}" for wheel in self._wheels]

    def feedback_names(self) -> Sequence[str]:
        """Return the position or velocity state interfaces of the wheels."""
        return [f"{wheel}/{self.feedback_type}" for wheel in self._wheels]

    def displacement(
        self, values: Sequence[float], last_values: Sequence[float], period: float
    ) -> BaseVelocity:
        """Return the base's displacement (m, m, rad) that fits all wheels best.

        The columns of the wheels' equations are orthogonal, since the wheels are at equal angles.
        So the least squares solution is a projection on each column: of squared length n/2 for x
        and y, and n R^2 for the turn.
        """
        if self._by_position:
            turned = [now - before for now, before in zip(values, last_values, strict=True)]
        else:
            turned = [speed * period for speed in values]
        x = y = turn = 0.0
        for (along, across), angle in zip(self._directions, turned, strict=True):
            x += along * angle
            y += across * angle
            turn -= angle
        mean = self._radius / len(turned)
        return BaseVelocity(2.0 * mean * x, 2.0 * mean * y, mean * turn / self._distance)

    def wheel_commands(self, velocity: BaseVelocity) -> Sequence[float]:
        """Return the velocity of each wheel (rad/s) for a velocity of the base."""
        turn = velocity.angular * self._distance
        return [
            (along * velocity.x + across * velocity.y - turn) / self._radius
            for along, across in self._directions
        ]

"""Odometry of a mobile base: pose and velocity integrated from displacements."""

from __future__ import annotations

import math
from collections import deque

# Turn in rad below which an arc is a line to double precision.
_STRAIGHT = 1e-6
# Period in s below which a computed speed is noise, as in ROS 2.
_SHORTEST_STEP = 1e-4


class Odometry:
    """Pose of a base in the odometry frame, integrated from displacements, and mean velocity.

    Args:
        window: Number of steps that the velocity is averaged over.

    Attributes:
        x: Position along x in the odometry frame, m.
        y: Position along y in the odometry frame, m.
        heading: Yaw in the odometry frame, rad.
        linear_x: Mean forward velocity in the base's frame, m/s.
        linear_y: Mean velocity to the left in the base's frame, m/s.
        angular: Mean angular velocity, counterclockwise, rad/s.
    """

    def __init__(self, window: int = 1) -> None:
        self._steps: deque[tuple[float, float, float]] = deque(maxlen=max(1, window))
        self.reset()

    def reset(self) -> None:
        """Reset the pose to the origin and the velocity to zero."""
        self.x = self.y = self.heading = 0.0
        self.linear_x = self.linear_y = self.angular = 0.0
        self._steps.clear()

    def export_state(self) -> dict[str, object]:
        """Return pose and velocities by attribute, and the last steps."""
        return vars(self) | {"_steps": list(self._steps)}

    def import_state(self, state: dict[str, object]) -> None:
        """Set the state to that of `export_state` of another odometry."""
        window = self._steps.maxlen
        vars(self).update(state)
        self._steps = deque(self._steps, maxlen=window)

    def advance(self, forwards: float, turned: float, period: float, sideways: float = 0.0) -> None:
        """Move the pose along an arc and update the mean velocity; ignore periods below 0.1 ms.

        Args:
            forwards: Length along the base's x axis, m.
            turned: Change of heading, rad.
            period: Duration of the motion in seconds.
            sideways: Length along the base's y axis, m.
        """
        if period < _SHORTEST_STEP:
            return
        heading = self.heading
        if abs(turned) < _STRAIGHT:
            # The chord of a short arc points along its mean heading.
            cosine, sine = math.cos(heading + turned / 2.0), math.sin(heading + turned / 2.0)
        else:
            cosine = (math.sin(heading + turned) - math.sin(heading)) / turned
            sine = (math.cos(heading) - math.cos(heading + turned)) / turned
        self.x += forwards * cosine - sideways * sine
        self.y += forwards * sine + sideways * cosine
        self.heading = heading + turned
        self._steps.append((forwards / period, sideways / period, turned / period))
        count = len(self._steps)
        self.linear_x, self.linear_y, self.angular = (
            sum(column) / count for column in zip(*self._steps, strict=True)
        )

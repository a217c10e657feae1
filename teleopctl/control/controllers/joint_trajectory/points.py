"""One point of a trajectory, as plain lists of floats.

Plain floats, not numpy: for the handful of joints of an arm, numpy's overhead for each call costs
more than the arithmetic.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from teleopctl.interfaces import Stamp, set_stamp, to_nanoseconds


class PointLike(Protocol):
    """Interface of trajectory_msgs/JointTrajectoryPoint."""

    positions: Sequence[float]
    velocities: Sequence[float]
    accelerations: Sequence[float]
    effort: Sequence[float]
    time_from_start: Stamp


@dataclass(slots=True)
class TrajectoryPoint:
    """State of all joints at one time; empty lists mean "not given".

    Attributes:
        positions: rad or m, one for each joint.
        velocities: rad/s or m/s.
        accelerations: rad/s² or m/s².
        effort: N·m or N.
        time_ns: Nanoseconds since the start of the trajectory.
    """

    positions: list[float] = field(default_factory=list)
    velocities: list[float] = field(default_factory=list)
    accelerations: list[float] = field(default_factory=list)
    effort: list[float] = field(default_factory=list)
    time_ns: int = 0

    @classmethod
    def from_message(cls, point: PointLike, order: Iterable[int] | None = None) -> TrajectoryPoint:
        """Return the point of a message, with joints reordered by ``order``."""
        indices = None if order is None else tuple(order)

        def take(values: Sequence[float]) -> list[float]:
            if indices is None or not len(values):
                return [float(value) for value in values]
            return [float(values[index]) for index in indices]

        return cls(
            take(point.positions),
            take(point.velocities),
            take(point.accelerations),
            take(point.effort),
            to_nanoseconds(point.time_from_start),
        )

    def copy_to(self, message: PointLike) -> None:
        """Fill a message."""
        message.positions = self.positions
        message.velocities = self.velocities
        message.accelerations = self.accelerations
        message.effort = self.effort
        set_stamp(message.time_from_start, self.time_ns)

"""A trajectory that can be sampled at any time.

Times are nanoseconds on the controller's clock. A trajectory begins at the "point before": where
the robot is when it takes the trajectory over.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from enum import Enum
from typing import NamedTuple

from teleopctl.control.controllers.joint_trajectory.points import TrajectoryPoint
from teleopctl.control.controllers.joint_trajectory.segment import TrajectorySegment
from teleopctl.interfaces import NANOSECONDS_PER_SECOND


class InterpolationMethod(Enum):
    """Method of interpolation between the points of a trajectory."""

    SPLINES = "splines"
    NONE = "none"


class TrajectorySample(NamedTuple):
    """State of a trajectory at one time.

    Attributes:
        state: The desired state.
        start_index: Index of the point that begins the running segment.
        end_index: Index of the point being approached; both are 0 before the first point, and
            ``end_index`` is the number of points after the last.
    """

    state: TrajectoryPoint
    start_index: int
    end_index: int


class Trajectory:
    """Trajectory points and the interpolated segments between them.

    Args:
        points: The points, their times strictly increasing. They are filled in where derivatives
            are integrated, so the trajectory owns them.
        start_ns: Time at which the points' clocks start, or 0 for "when first sampled".
    """

    def __init__(self, points: Sequence[TrajectoryPoint] = (), start_ns: int = 0) -> None:
        self._points: list[TrajectoryPoint] = []
        self._segments: list[TrajectorySegment | None] = []
        self._before: TrajectoryPoint | None = None
        self.update(points, start_ns)

    def update(self, points: Sequence[TrajectoryPoint], start_ns: int = 0) -> None:
        """Replace the points; the point before the trajectory stays."""
        self._points = list(points)
        # Segment i ends at point i; the first one begins at the point before.
        self._segments = [None] * len(self._points)
        self.start_ns = start_ns
        self._completed = 0
        self.last_index = 0
        self.sampled_already = False

    @property
    def points(self) -> Sequence[TrajectoryPoint]:
        """Points of the trajectory, not to be changed."""
        return self._points

    @property
    def end_ns(self) -> int:
        """Time of the last point; valid once the start time is known."""
        return self.start_ns + (self._points[-1].time_ns if self._points else 0)

    def set_point_before(
        self, time_ns: int, point: TrajectoryPoint, wraparound: Sequence[bool] = ()
    ) -> None:
        """Set the robot's state when it starts to follow the trajectory.

        Args:
            time_ns: The time of that state; the trajectory cannot be sampled before it.
            point: The state; it must have positions.
            wraparound: Per joint, whether a whole turn leads back to the same place. Such a
                joint's position before is shifted by turns, so that it takes the shortest way.
        """
        before = replace(point, time_ns=time_ns)
        if any(wraparound) and self._points and self._points[0].positions:
            before.positions = shortest_way(before.positions, self._points[0].positions, wraparound)
        self._before = before
        if self._segments:
            self._segments[0] = None

    def sample(
        self,
        time_ns: int,
        method: InterpolationMethod = InterpolationMethod.SPLINES,
        *,
        advance: bool = True,
    ) -> TrajectorySample | None:
        """Return the desired state at a time; None outside the trajectory.

        There is none without points and before the point before.

        Args:
            time_ns: The time; never earlier than that of the last call that advanced.
            method: How to interpolate.
            advance: Whether later calls may begin their search here.
        """
        if not self.sampled_already:
            self.sampled_already = True
            if self.start_ns == 0:
                self.start_ns = time_ns
        points = self._points
        before = self._before
        if not points or before is None or time_ns < before.time_ns:
            return None
        elapsed = time_ns - self.start_ns
        splines = method is InterpolationMethod.SPLINES
        if elapsed < points[0].time_ns:
            if not splines:
                return TrajectorySample(before, 0, 0)
            return self._interpolate(0, time_ns, 0, 0)
        last = len(points) - 1
        for index in range(self.last_index, last):
            if points[index].time_ns <= elapsed < points[index + 1].time_ns:
                if advance:
                    self.last_index = index
                if not splines:
                    return TrajectorySample(points[index + 1], index, index + 1)
                return self._interpolate(index + 1, time_ns, index, index + 1)
        if advance:
            self.last_index = last
        if splines:
            self._complete(last)
        return TrajectorySample(_with_zeros(points[last]), last, last + 1)

    def _interpolate(self, segment: int, time_ns: int, start: int, end: int) -> TrajectorySample:
        path = self._segments[segment]
        if path is None:
            self._complete(segment)
            begin_ns, begin = self._begin_of(segment)
            target = self._points[segment]
            if segment == 0:
                begin = _padded(begin, target)
            path = TrajectorySegment(begin_ns, begin, self.start_ns + target.time_ns, target)
            self._segments[segment] = path
        return TrajectorySample(path.sample(time_ns), start, end)

    def _begin_of(self, segment: int) -> tuple[int, TrajectoryPoint]:
        if segment == 0:
            assert self._before is not None
            return self._before.time_ns, self._before
        point = self._points[segment - 1]
        return self.start_ns + point.time_ns, point

    def _complete(self, segment: int) -> None:
        """Integrate what the ends of all segments up to this one lack.

        Also of those that no sample has fallen into: at 10 Hz a sample may step over several.
        """
        for index in range(self._completed, segment + 1):
            target = self._points[index]
            begin_ns, begin = self._begin_of(index)
            duration = max(0, self.start_ns + target.time_ns - begin_ns) / NANOSECONDS_PER_SECOND
            integrate(begin, target, duration)
        self._completed = max(self._completed, segment + 1)


def integrate(begin: TrajectoryPoint, end: TrajectoryPoint, duration: float) -> None:
    """Fill in missing positions and velocities of ``end`` by integration.

    Velocity and acceleration run linearly over the segment; those that ``begin`` lacks count as 0.

    Args:
        begin: State at the beginning, with positions.
        end: State to be completed.
        duration: Seconds between them.
    """
    if end.positions or not (end.velocities or end.accelerations):
        return
    zeros = [0.0] * len(begin.positions)
    velocities = begin.velocities or zeros
    if not end.velocities:
        accelerations = begin.accelerations or zeros
        end.velocities = [
            v + (a + b) * duration / 2.0
            for v, a, b in zip(velocities, accelerations, end.accelerations, strict=True)
        ]
    end.positions = [
        p + (v + w) * duration / 2.0
        for p, v, w in zip(begin.positions, velocities, end.velocities, strict=True)
    ]


def shortest_way(
    current: Sequence[float], target: Sequence[float], wraparound: Sequence[bool]
) -> list[float]:
    """Shift flagged positions by whole turns, so that each is at most half a turn from its target.

    Args:
        current: Positions, rad.
        target: Where they are to go, rad.
        wraparound: Which joints turn without end.
    """
    return [
        end - shortest_angle(begin, end) if flag else begin
        for begin, end, flag in zip(current, target, wraparound, strict=True)
    ]


def shortest_angle(begin: float, end: float) -> float:
    """Return the shortest rotation from one angle to another, rad.

    Args:
        begin: Angle, rad.
        end: Angle, rad.
    """
    difference = math.remainder(end - begin, 2.0 * math.pi)
    if abs(abs(difference) - math.pi) < 1e-12:
        return math.copysign(math.pi, end - begin)
    return difference


def _padded(begin: TrajectoryPoint, target: TrajectoryPoint) -> TrajectoryPoint:
    """Give the point before the derivatives that the first point has; they count as 0."""
    zeros = [0.0] * len(begin.positions)
    return replace(
        begin,
        velocities=begin.velocities or (list(zeros) if target.velocities else []),
        accelerations=begin.accelerations or (list(zeros) if target.accelerations else []),
    )


def _with_zeros(point: TrajectoryPoint) -> TrajectoryPoint:
    zeros = [0.0] * len(point.positions)
    return replace(
        point,
        velocities=point.velocities or zeros,
        accelerations=point.accelerations or list(zeros),
    )

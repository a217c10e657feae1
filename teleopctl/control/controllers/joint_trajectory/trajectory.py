"""Joint trajectories: their points, splines between points, and sampling.

Plain floats, not numpy: for the few joints of an arm, numpy's overhead for each call costs more
than the arithmetic. Times are nanoseconds on the controller's clock. A trajectory begins at the
"point before": the robot's state when it starts to follow the trajectory. The degree of a segment
(linear, cubic or quintic) depends on the derivatives that both its points have; its coefficients
are computed once.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple, Protocol

from teleopctl.interfaces import NANOSECONDS_PER_SECOND, Stamp, set_stamp, to_nanoseconds


class PointLike(Protocol):
    """Interface of trajectory_msgs/JointTrajectoryPoint."""

    positions: Sequence[float]
    velocities: Sequence[float]
    accelerations: Sequence[float]
    effort: Sequence[float]
    time_from_start: Stamp


@dataclass(slots=True)
class TrajectoryPoint:
    """Positions, velocities, accelerations and efforts of all joints at one time.

    Attributes:
        positions: Position of each joint, rad or m.
        velocities: Velocity of each joint, rad/s or m/s; may be empty.
        accelerations: Acceleration of each joint, rad/s² or m/s²; may be empty.
        effort: Effort of each joint, N·m or N; may be empty.
        time_ns: Nanoseconds since the start of the trajectory.
    """

    positions: list[float] = field(default_factory=list)
    velocities: list[float] = field(default_factory=list)
    accelerations: list[float] = field(default_factory=list)
    effort: list[float] = field(default_factory=list)
    time_ns: int = 0

    def at(self, time_ns: int) -> TrajectoryPoint:
        """Return the point with another time; the lists are shared."""
        return TrajectoryPoint(
            self.positions, self.velocities, self.accelerations, self.effort, time_ns
        )

    @classmethod
    def from_message(cls, point: PointLike, order: Iterable[int] | None = None) -> TrajectoryPoint:
        """Return the point of a message; its joints reordered by indices if given."""
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
        """Copy the point's values into a JointTrajectoryPoint message."""
        message.positions = self.positions
        message.velocities = self.velocities
        message.accelerations = self.accelerations
        message.effort = self.effort
        set_stamp(message.time_from_start, self.time_ns)


class TrajectorySegment:
    """Interpolation between two trajectory points: linear, cubic or quintic.

    Args:
        begin_ns: Begin of the segment, nanoseconds on any clock.
        begin: State at the begin; must have positions.
        end_ns: End of the segment, nanoseconds on the same clock.
        end: State at the end; must have positions.
    """

    __slots__ = ("_begin_ns", "_coefficients", "_degree", "_duration", "_effort")

    def __init__(
        self, begin_ns: int, begin: TrajectoryPoint, end_ns: int, end: TrajectoryPoint
    ) -> None:
        self._begin_ns = begin_ns
        self._duration = duration = max(0, end_ns - begin_ns) / NANOSECONDS_PER_SECOND
        has_velocities = bool(begin.velocities and end.velocities)
        if has_velocities and begin.accelerations and end.accelerations:
            self._degree = 5
            self._coefficients = [
                quintic(pa, va, aa, pb, vb, ab, duration)
                for pa, va, aa, pb, vb, ab in zip(
                    begin.positions,
                    begin.velocities,
                    begin.accelerations,
                    end.positions,
                    end.velocities,
                    end.accelerations,
                    strict=True,
                )
            ]
        elif has_velocities:
            self._degree = 3
            self._coefficients = [
                cubic(*joint, duration)
                for joint in zip(
                    begin.positions, begin.velocities, end.positions, end.velocities, strict=True
                )
            ]
        else:
            self._degree = 1
            self._coefficients = _lines(begin.positions, end.positions, duration)
        self._effort = (
            _lines(begin.effort, end.effort, duration) if begin.effort and end.effort else []
        )

    def sample(self, time_ns: int) -> TrajectoryPoint:
        """Return the interpolated state at a time, clamped to the segment's ends."""
        t = (time_ns - self._begin_ns) / NANOSECONDS_PER_SECOND
        t = min(max(t, 0.0), self._duration)
        if self._degree == 1:
            positions = [c0 + c1 * t for c0, c1 in self._coefficients]
            velocities = [c1 for _, c1 in self._coefficients]
            accelerations = [0.0] * len(positions)
        elif self._degree == 3:
            cubics = self._coefficients
            positions = [((c3 * t + c2) * t + c1) * t + c0 for c0, c1, c2, c3 in cubics]
            velocities = [(3.0 * c3 * t + 2.0 * c2) * t + c1 for _, c1, c2, c3 in cubics]
            accelerations = [6.0 * c3 * t + 2.0 * c2 for _, _, c2, c3 in cubics]
        else:
            positions, velocities, accelerations = [], [], []
            for c0, c1, c2, c3, c4, c5 in self._coefficients:
                positions.append(((((c5 * t + c4) * t + c3) * t + c2) * t + c1) * t + c0)
                velocities.append(
                    (((5.0 * c5 * t + 4.0 * c4) * t + 3.0 * c3) * t + 2.0 * c2) * t + c1
                )
                accelerations.append(((20.0 * c5 * t + 12.0 * c4) * t + 6.0 * c3) * t + 2.0 * c2)
        effort = [c0 + c1 * t for c0, c1 in self._effort]
        return TrajectoryPoint(positions, velocities, accelerations, effort, time_ns)


def _lines(
    begin: Sequence[float], end: Sequence[float], duration: float
) -> list[tuple[float, ...]]:
    if duration == 0.0:
        return [(value, 0.0) for value in begin]
    return [(first, (last - first) / duration) for first, last in zip(begin, end, strict=True)]


def cubic(pa: float, va: float, pb: float, vb: float, duration: float) -> tuple[float, ...]:
    """Return coefficients c0…c3 of the cubic from position pa, velocity va to pb, vb."""
    if duration == 0.0:
        return pa, va, 0.0, 0.0
    d = duration
    return (
        pa,
        va,
        (3.0 * (pb - pa) - (2.0 * va + vb) * d) / d**2,
        (2.0 * (pa - pb) + (va + vb) * d) / d**3,
    )


def quintic(
    pa: float, va: float, aa: float, pb: float, vb: float, ab: float, duration: float
) -> tuple[float, ...]:
    """Return c0…c5 of the quintic from position pa, velocity va, acceleration aa to pb, vb, ab."""
    if duration == 0.0:
        return pa, va, aa / 2.0, 0.0, 0.0, 0.0
    d = duration
    step = pb - pa
    return (
        pa,
        va,
        aa / 2.0,
        (20.0 * step - (8.0 * vb + 12.0 * va) * d - (3.0 * aa - ab) * d**2) / (2.0 * d**3),
        (-30.0 * step + (14.0 * vb + 16.0 * va) * d + (3.0 * aa - 2.0 * ab) * d**2) / (2.0 * d**4),
        (12.0 * step - 6.0 * (vb + va) * d - (aa - ab) * d**2) / (2.0 * d**5),
    )


class InterpolationMethod(Enum):
    """Interpolation between trajectory points: splines, or none (jump to the next point)."""

    SPLINES = "splines"
    NONE = "none"


class TrajectorySample(NamedTuple):
    """State sampled from a trajectory, with the indices of the points before and after.

    Attributes:
        state: Desired state.
        start_index: Index of the point at the begin of the present segment.
        end_index: Index of the point at the end of the present segment; both are 0 before the
            first point, and ``end_index`` is the number of points after the last point.
    """

    state: TrajectoryPoint
    start_index: int
    end_index: int


class Trajectory:
    """Trajectory points with a start time; returns interpolated states.

    Args:
        points: Points with strictly increasing times. The trajectory owns the points: it completes
            those whose derivatives are to be integrated.
        start_ns: Start time that the points' times are relative to; 0 for the first sampling.
    """

    def __init__(self, points: Sequence[TrajectoryPoint] = (), start_ns: int = 0) -> None:
        self._points: list[TrajectoryPoint] = []
        self._segments: list[TrajectorySegment | None] = []
        self._before: TrajectoryPoint | None = None
        self.update(points, start_ns)

    def update(self, points: Sequence[TrajectoryPoint], start_ns: int = 0) -> None:
        """Replace the points and start time; keep the start state of `set_point_before`."""
        self._points = list(points)
        # Segment i ends at point i; the first segment begins at the point before.
        self._segments = [None] * len(self._points)
        self.start_ns = start_ns
        self._completed = 0
        # The sample after the last point, the same in each cycle until the next trajectory, and
        # whether it was made for splines.
        self._last_sample: TrajectorySample | None = None
        self._last_sample_splines = False
        self.last_index = 0
        self.sampled_already = False

    @property
    def points(self) -> Sequence[TrajectoryPoint]:
        """Points of the trajectory; callers must not change them."""
        return self._points

    @property
    def point_before(self) -> TrajectoryPoint | None:
        """State of the robot before the first point; None if it is not set."""
        return self._before

    @property
    def end_ns(self) -> int:
        """Time of the last point in nanoseconds, valid once the start time is known."""
        return self.start_ns + (self._points[-1].time_ns if self._points else 0)

    def set_point_before(
        self, time_ns: int, point: TrajectoryPoint, wraparound: Sequence[bool] = ()
    ) -> None:
        """Set the robot's state when it starts to follow the trajectory, before the first point.

        Args:
            time_ns: Time of that state; earlier times cannot be sampled.
            point: State of the robot; must have positions.
            wraparound: Whether each joint is continuous. The position of a continuous joint is
                shifted by whole turns, so that the joint takes the shortest way.
        """
        before = point.at(time_ns)
        if any(wraparound) and self._points and self._points[0].positions:
            before.positions = shift_to_nearest_turn(
                before.positions, self._points[0].positions, wraparound
            )
        self._before = before
        self._last_sample = None
        if self._segments:
            self._segments[0] = None

    def sample(
        self,
        time_ns: int,
        method: InterpolationMethod = InterpolationMethod.SPLINES,
        *,
        advance: bool = True,
    ) -> TrajectorySample | None:
        """Return a `TrajectorySample` at a time; None without points or before the start state.

        Args:
            time_ns: Time of the state; not earlier than that of the last call with ``advance``.
            method: Interpolation method.
            advance: Whether later calls may start their search at this time.
        """
        splines = method is InterpolationMethod.SPLINES
        held = self._last_sample
        if (
            held is not None
            and self._last_sample_splines is splines
            and time_ns - self.start_ns >= self._points[-1].time_ns
        ):
            if advance:
                self.last_index = held.start_index
            return held
        if not self.sampled_already:
            self.sampled_already = True
            if self.start_ns == 0:
                self.start_ns = time_ns
        points = self._points
        before = self._before
        if not points or before is None or time_ns < before.time_ns:
            return None
        elapsed = time_ns - self.start_ns
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
        self._last_sample = TrajectorySample(_with_zeros(points[last]), last, last + 1)
        self._last_sample_splines = splines
        return self._last_sample

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
        """Integrate missing derivatives at the end of all segments up to this one.

        Segments without a sample are included: at 10 Hz a sample may skip several of them.
        """
        for index in range(self._completed, segment + 1):
            target = self._points[index]
            begin_ns, begin = self._begin_of(index)
            duration = max(0, self.start_ns + target.time_ns - begin_ns) / NANOSECONDS_PER_SECOND
            integrate(begin, target, duration)
        self._completed = max(self._completed, segment + 1)


def integrate(begin: TrajectoryPoint, end: TrajectoryPoint, duration: float) -> None:
    """Set missing positions and velocities of a segment's end point by integration, in place.

    Velocity and acceleration are linear over the segment; those that ``begin`` lacks count as 0.

    Args:
        begin: State at the begin, with positions.
        end: State at the end, which is completed.
        duration: Duration of the segment in seconds.
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


def shift_to_nearest_turn(
    current: Sequence[float], target: Sequence[float], wraparound: Sequence[bool]
) -> list[float]:
    """Return `current`, continuous joints shifted by full turns to be nearest to their targets.

    Args:
        current: Present positions, rad.
        target: Target positions, rad.
        wraparound: Whether each joint is continuous.
    """
    return [
        end - shortest_angle(begin, end) if flag else begin
        for begin, end, flag in zip(current, target, wraparound, strict=True)
    ]


def shortest_angle(begin: float, end: float) -> float:
    """Return the shortest signed rotation from one angle to another, in rad.

    Args:
        begin: First angle, rad.
        end: Second angle, rad.
    """
    difference = math.remainder(end - begin, 2.0 * math.pi)
    if abs(abs(difference) - math.pi) < 1e-12:
        return math.copysign(math.pi, end - begin)
    return difference


def _padded(begin: TrajectoryPoint, target: TrajectoryPoint) -> TrajectoryPoint:
    """Return the point before, with zeros for derivatives that only the first point has."""
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

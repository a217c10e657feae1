"""The path between two neighbouring points: linear, cubic or quintic.

The degree follows from what both ends have. Coefficients are computed once, when a segment is
entered; sampling it is then a Horner scheme for each joint.
"""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.control.controllers.joint_trajectory.points import TrajectoryPoint
from teleopctl.interfaces import NANOSECONDS_PER_SECOND


class TrajectorySegment:
    """Interpolation between two trajectory points.

    Args:
        begin_ns: Time of the first end, nanoseconds on any clock.
        begin: State at that time; must have positions.
        end_ns: Time of the second end on the same clock.
        end: State at that time; must have positions.
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
        """Return the state at a time, clamped to the segment."""
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
    """Coefficients c0…c3 of the cubic with given positions and velocities at both ends."""
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
    """Coefficients c0…c5 of the quintic that also has given accelerations at both ends."""
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

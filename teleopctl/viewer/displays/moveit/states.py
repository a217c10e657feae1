"""Joint positions out of MoveIt's messages, and how a planned path is played."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass
from typing import Any

from teleopctl.viewer.scene.drawing import is_drawable

# Any stands for messages throughout: their classes are made at run time, from definitions.

Positions = dict[str, float]
_PERIOD = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*s\s*\Z", re.IGNORECASE)
_FACTOR = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*x\s*\Z", re.IGNORECASE)
# MoveIt's own, where the text makes no sense.
_DEFAULT_PERIOD_S = 0.05


def positions_in(joint_state: Any) -> tuple[Positions, int]:
    """Return the finite positions of a ``sensor_msgs/msg/JointState``, and how many are not."""
    return _zipped(joint_state.name, joint_state.position)


def _zipped(names: Any, values: Any) -> tuple[Positions, int]:
    pairs = [(name, float(value)) for name, value in zip(names, values, strict=False)]
    good = {name: value for name, value in pairs if is_drawable((value,))}
    return good, sum(not is_drawable((value,)) for _, value in pairs)


def left_out_text(count: int) -> str:
    """Return a sentence about joint positions that are no numbers; empty for none."""
    one = "1 joint position is" if count == 1 else f"{count} joint positions are"
    return f"{one} left out, not being numbers"


@dataclass(frozen=True, slots=True)
class PlannedPath:
    """A planned path: joint positions over time.

    Attributes:
        times: When each state is reached, in seconds from the start, never falling.
        states: The positions of joints at those times.
        left_out: How many positions are no numbers, so that a joint stays where it was.
    """

    times: tuple[float, ...]
    states: tuple[Positions, ...]
    left_out: int = 0

    @classmethod
    def of(cls, message: Any) -> PlannedPath:
        """Read a ``moveit_msgs/msg/DisplayTrajectory``, with its trajectories in sequence."""
        state, left_out = positions_in(message.trajectory_start.joint_state)
        times: list[float] = []
        states: list[Positions] = []
        begin = 0.0
        for trajectory in message.trajectory:
            joints = trajectory.joint_trajectory
            for point in joints.points:
                positions, wrong = _zipped(joints.joint_names, point.positions)
                state, left_out = {**state, **positions}, left_out + wrong
                at = begin + point.time_from_start.sec + point.time_from_start.nanosec * 1e-9
                times.append(max(at, times[-1] if times else 0.0))
                states.append(state)
            begin = times[-1] if times else 0.0
        return cls(tuple(times), tuple(states), left_out)

    def duration(self, display_time: str) -> float:
        """Return the duration of the path's animation, in seconds.

        Args:
            display_time: RViz's property: ``0.05 s`` for each state, ``3x`` as fast as planned, or
                ``REALTIME``.
        """
        period, factor = _speed(display_time)
        if factor is not None and self.times and self.times[-1] > 0.0:
            return self.times[-1] / factor
        return period * len(self.states)

    def at(self, elapsed: float, display_time: str) -> Positions:
        """Return the joint positions to show after so many seconds.

        Args:
            elapsed: Seconds since it began.
            display_time: See `duration`.
        """
        period, factor = _speed(display_time)
        if factor is None or self.times[-1] <= 0.0:
            return self.states[min(int(elapsed / period), len(self.states) - 1)]
        time = elapsed * factor
        after = bisect_right(self.times, time)
        if after == 0 or after == len(self.times):
            return self.states[min(after, len(self.times) - 1)]
        # Between two states on a straight line: as controllers follow it, and smooth to look at.
        before, start, end = after - 1, self.times[after - 1], self.times[after]
        part = (time - start) / (end - start)
        last, following = self.states[before], self.states[after]
        return {
            name: value + part * (following.get(name, value) - value)
            for name, value in last.items()
        }


def _speed(display_time: str) -> tuple[float, float | None]:
    """Seconds for each state, and how many times faster than planned; None for the former."""
    if display_time.strip().upper() == "REALTIME":
        return _DEFAULT_PERIOD_S, 1.0
    if (factor := _FACTOR.match(display_time)) and float(factor[1]) > 0.0:
        return _DEFAULT_PERIOD_S, float(factor[1])
    if (period := _PERIOD.match(display_time)) and float(period[1]) > 0.0:
        return float(period[1]), None
    return _DEFAULT_PERIOD_S, None

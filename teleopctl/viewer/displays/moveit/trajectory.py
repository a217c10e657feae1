"""MoveIt's ``Trajectory``: an animation of the newest planned path."""

from __future__ import annotations

import re
import time
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.moveit.base import MoveItDisplay, RobotOverlay
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.scene.drawing import is_drawable

# Any: messages, whose classes are created from definitions at run time.

Positions = dict[str, float]
_PERIOD = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*s\s*\Z", re.IGNORECASE)
_FACTOR = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*x\s*\Z", re.IGNORECASE)
# MoveIt's default, used for an invalid text.
_DEFAULT_PERIOD_S = 0.05


def joint_positions_of(joint_state: Any) -> tuple[Positions, int]:
    """Return a JointState's finite positions by joint, and the number of non-finite ones."""
    return _zipped(joint_state.name, joint_state.position)


def _zipped(names: Any, values: Any) -> tuple[Positions, int]:
    pairs = [(name, float(value)) for name, value in zip(names, values, strict=False)]
    good = {name: value for name, value in pairs if is_drawable((value,))}
    return good, sum(not is_drawable((value,)) for _, value in pairs)


def invalid_positions_text(count: int) -> str:
    """Return the status text that ``count`` joint positions are not finite."""
    one = "1 joint position is" if count == 1 else f"{count} joint positions are"
    return f"{one} left out: not a finite number"


@dataclass(frozen=True, slots=True)
class PlannedPath:
    """Planned path of a DisplayTrajectory message: joint positions over time.

    Attributes:
        times: Time of each state in seconds from the start, in ascending order.
        states: Joint positions at these times.
        left_out: Number of positions that are not finite; their joints keep the previous position.
    """

    times: tuple[float, ...]
    states: tuple[Positions, ...]
    left_out: int = 0

    @classmethod
    def from_message(cls, message: Any) -> PlannedPath:
        """Return a DisplayTrajectory message as one path, its trajectories joined."""
        state, left_out = joint_positions_of(message.trajectory_start.joint_state)
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
        """Return the animation's duration (s) for RViz's property ``State Display Time``.

        Args:
            display_time: RViz's property "State Display Time": ``0.05 s`` for each state, ``3x`` as
                fast as planned, or ``REALTIME``.
        """
        period, factor = _speed(display_time)
        if factor is not None and self.times and self.times[-1] > 0.0:
            return self.times[-1] / factor
        return period * len(self.states)

    def at(self, elapsed: float, display_time: str) -> Positions:
        """Return the joint positions to show ``elapsed`` seconds after the animation's start.

        Args:
            elapsed: Seconds since the animation started.
            display_time: RViz's property "State Display Time"; see `duration`.
        """
        period, factor = _speed(display_time)
        if factor is None or self.times[-1] <= 0.0:
            return self.states[min(int(elapsed / period), len(self.states) - 1)]
        time = elapsed * factor
        after = bisect_right(self.times, time)
        if after == 0 or after == len(self.times):
            return self.states[min(after, len(self.times) - 1)]
        # Linear interpolation between two states: smooth, and as controllers follow the path.
        before, start, end = after - 1, self.times[after - 1], self.times[after]
        part = (time - start) / (end - start)
        last, following = self.states[before], self.states[after]
        return {
            name: value + part * (following.get(name, value) - value)
            for name, value in last.items()
        }


def _speed(display_time: str) -> tuple[float, float | None]:
    """Return the seconds per state, and the factor of the planned speed; None without factor."""
    if display_time.strip().upper() == "REALTIME":
        return _DEFAULT_PERIOD_S, 1.0
    if (factor := _FACTOR.match(display_time)) and float(factor[1]) > 0.0:
        return _DEFAULT_PERIOD_S, float(factor[1])
    if (period := _PERIOD.match(display_time)) and float(period[1]) > 0.0:
        return float(period[1]), None
    return _DEFAULT_PERIOD_S, None


_TRAIL_MOST = 20

PATH_PROPERTIES = (
    Property("Robot Alpha", 0.5, low=0.0, high=1.0),
    Property("Color Enabled", False, hint="Draw all links in one colour"),
    Property("Robot Color", (150, 50, 150)),
    Property("State Display Time", "3x", hint="Seconds for each state as 0.05 s, 3x, or REALTIME"),
    Property("Loop Animation", False),
    Property("Show Trail", False, hint="Draw the states along the path"),
    Property("Trail Step Size", 1, low=1, high=1000, hint="Draw every n-th state"),
    Property(
        "Interrupt Display", False, hint="Start a new path before the animation of the old one ends"
    ),
)


class TrajectoryDisplay(MoveItDisplay):
    """MoveIt's ``Trajectory`` display: the newest planned path, animated once or repeatedly.

    Attributes:
        other_poses: Poses of the links of another drawn robot; see `RobotOverlay.set_positions`.
    """

    rviz_class = "Trajectory"
    message_type = "moveit_msgs/msg/DisplayTrajectory"
    topic_key = "Trajectory Topic"
    default_topic = "/display_planned_path"
    properties: ClassVar[tuple[Property, ...]] = PATH_PROPERTIES

    def _prepare(self) -> None:
        super()._prepare()
        self._path: PlannedPath | None = None
        self._next: PlannedPath | None = None
        self._began = 0.0
        self._playing = False
        self._overlay: RobotOverlay | None = None
        self._trail: list[RobotOverlay] = []
        self.other_poses: Mapping[str, Transform] = {}

    @property
    def last_path(self) -> PlannedPath | None:
        """The newest received path, even while it waits to be shown; None if none."""
        return self._next or self._path

    @property
    def is_playing(self) -> bool:
        """Whether a path is animated."""
        return self._playing

    def received(self, message: Any) -> None:
        """Start the animation of a path, or queue it until the running one ends."""
        path = PlannedPath.from_message(message)
        if not path.states:
            self.set_status(WARN, "The path has no states")
            return
        self._next = path
        said = f"{len(path.states)} states in {path.times[-1]:.3g} s"
        if path.left_out:
            self.set_status(WARN, f"{said}; {invalid_positions_text(path.left_out)}")
        else:
            self.set_status(OK, said)
        if not self._playing or self.values.flag("Interrupt Display"):
            self._begin()

    def redraw(self) -> None:
        """Redraw the trail; the animated robot follows with the next `tick`."""
        self._remove()
        if self._path is not None:
            self._draw_trail(self._path)

    def clear(self) -> None:
        """Remove the robot and the trail from the scene, and drop the path."""
        self._remove()
        self._path = self._next = None
        self._playing = False

    def tick(self) -> None:
        """Advance the animation; at its end start the queued path, repeat, or hide the robot."""
        if not self._playing or self._path is None:
            return
        if self._overlay is None:
            self._overlay = self._make("path")
            if self._overlay is None:
                return
        elapsed = time.monotonic() - self._began
        display_time = self.values.text("State Display Time")
        if elapsed <= self._path.duration(display_time):
            self._overlay.set_positions(self._path.at(elapsed, display_time), self.other_poses)
        elif self._next is not None:
            self._begin()
        elif self.values.flag("Loop Animation"):
            self._began = time.monotonic()
        else:
            self._playing = False
            self._overlay.show(shown=False)

    def _begin(self) -> None:
        self._path, self._next = self._next, None
        self._began, self._playing = time.monotonic(), True
        if self._path is not None:
            self._draw_trail(self._path)

    def _draw_trail(self, path: PlannedPath) -> None:
        for overlay in self._trail:
            overlay.remove()
        self._trail.clear()
        if not self.values.flag("Show Trail") or self.model is None:
            return
        # Each robot consists of many nodes: more robots would slow down the browser.
        step = max(int(self.values.number("Trail Step Size")), -(-len(path.states) // _TRAIL_MOST))
        for number, state in enumerate(path.states[::step]):
            made = self._make(f"trail{number}")
            if made is not None:
                made.set_positions(state)
                self._trail.append(made)

    def _make(self, name: str) -> RobotOverlay | None:
        color = self.values.color("Robot Color") if self.values.flag("Color Enabled") else None
        return self.add_overlay(name, self.values.number("Robot Alpha"), color)

    def _remove(self) -> None:
        for overlay in (self._overlay, *self._trail):
            if overlay is not None:
                overlay.remove()
        self._overlay = None
        self._trail.clear()

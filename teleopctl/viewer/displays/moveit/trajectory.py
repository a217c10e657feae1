"""``TrajectoryDisplay``: a robot that moves along a planned path, before the real one does."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.moveit.base import MoveItDisplay
from teleopctl.viewer.displays.moveit.ghost import RobotOverlay
from teleopctl.viewer.displays.moveit.states import PlannedPath, left_out_text
from teleopctl.viewer.displays.properties import Property

# Any stands for messages throughout: their classes are made at run time, from definitions.

_TRAIL_MOST = 20

PATH_PROPERTIES = (
    Property("Robot Alpha", 0.5, low=0.0, high=1.0),
    Property("Color Enabled", False, hint="Draw all links in one colour"),
    Property("Robot Color", (150, 50, 150)),
    Property("State Display Time", "3x", hint="Seconds for each state as 0.05 s, 3x, or REALTIME"),
    Property("Loop Animation", False),
    Property("Show Trail", False, hint="Draw the states on the way"),
    Property("Trail Step Size", 1, low=1, high=1000, hint="Every so-manieth state is drawn"),
    Property("Interrupt Display", False, hint="A new path does not wait for the end of the old"),
)


class TrajectoryDisplay(MoveItDisplay):
    """Display of the newest trajectory, animated once or repeatedly.

    Attributes:
        besides: Where the links of a robot stand that is drawn besides; see `RobotOverlay.stand`.
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
        self._ghost: RobotOverlay | None = None
        self._trail: list[RobotOverlay] = []
        self.besides: Mapping[str, Transform] = {}

    @property
    def last_path(self) -> PlannedPath | None:
        """The newest path."""
        return self._next or self._path

    def received(self, message: Any) -> None:
        """Start the animation of a received path."""
        path = PlannedPath.of(message)
        if not path.states:
            self.say(WARN, "The path has no states")
            return
        self._next = path
        said = f"{len(path.states)} states in {path.times[-1]:.3g} s"
        if path.left_out:
            self.say(WARN, f"{said}; {left_out_text(path.left_out)}")
        else:
            self.say(OK, said)
        if not self._playing or self.values.flag("Interrupt Display"):
            self._begin()

    def described(self) -> None:
        """Redraw the robot for a new description."""
        self._remove()
        if self._path is not None:
            self._draw_trail(self._path)

    def cleared(self) -> None:
        """Remove the robot from the scene, and drop the path."""
        self._remove()
        self._path = self._next = None
        self._playing = False

    def tick(self) -> None:
        """Continue the animation of the path."""
        if not self._playing or self._path is None:
            return
        if self._ghost is None:
            self._ghost = self._make("path")
            if self._ghost is None:
                return
        elapsed = time.monotonic() - self._began
        display_time = self.values.text("State Display Time")
        if elapsed <= self._path.duration(display_time):
            self._ghost.stand(self._path.at(elapsed, display_time), self.besides)
        elif self._next is not None:
            self._begin()
        elif self.values.flag("Loop Animation"):
            self._began = time.monotonic()
        else:
            self._playing = False
            self._ghost.show(shown=False)

    def _begin(self) -> None:
        self._path, self._next = self._next, None
        self._began, self._playing = time.monotonic(), True
        if self._path is not None:
            self._draw_trail(self._path)

    def _draw_trail(self, path: PlannedPath) -> None:
        for ghost in self._trail:
            ghost.remove()
        self._trail.clear()
        if not self.values.flag("Show Trail") or self.model is None:
            return
        # A robot is many nodes: more than these would slow the browser down.
        step = max(int(self.values.number("Trail Step Size")), -(-len(path.states) // _TRAIL_MOST))
        for number, state in enumerate(path.states[::step]):
            made = self._make(f"trail{number}")
            if made is not None:
                made.stand(state)
                self._trail.append(made)

    def _make(self, name: str) -> RobotOverlay | None:
        color = self.values.color("Robot Color") if self.values.flag("Color Enabled") else None
        return self.make_ghost(name, self.values.number("Robot Alpha"), color)

    def _remove(self) -> None:
        for ghost in (self._ghost, *self._trail):
            if ghost is not None:
                ghost.remove()
        self._ghost = None
        self._trail.clear()

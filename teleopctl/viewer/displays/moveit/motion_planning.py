"""``MotionPlanning``: MoveIt's scene with the path that it has planned, and where that ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK
from teleopctl.viewer.displays.moveit.ghost import RobotOverlay
from teleopctl.viewer.displays.moveit.planning_scene import SCENE_PROPERTIES, PlanningScene
from teleopctl.viewer.displays.moveit.states import PlannedPath
from teleopctl.viewer.displays.moveit.trajectory import PATH_PROPERTIES, TrajectoryDisplay
from teleopctl.viewer.displays.properties import Property

# Any stands for messages throughout: their classes are made at run time, from definitions.

_PATH = "Planned PlannedPath"
_GOAL = "Planning Request"


class MotionPlanning(PlanningScene):
    """Display of the planning scene, the planned path and its goal state.

    In RViz the goal is dragged and plans are asked for; here what others plan is shown.
    """

    rviz_class = "MotionPlanning"
    properties: ClassVar[tuple[Property, ...]] = (
        *SCENE_PROPERTIES,
        *(replace(known, name=f"{_PATH}/{known.name}") for known in PATH_PROPERTIES),
        Property(f"{_GOAL}/Query Goal State", True, hint="Draw the robot where the path ends"),
        Property(f"{_GOAL}/Goal State Color", (250, 128, 0)),
        Property(f"{_GOAL}/Goal State Alpha", 1.0, low=0.0, high=1.0),
    )

    def _prepare(self) -> None:
        super()._prepare()
        given = self.values.given.setdefault(_PATH, {})
        if not isinstance(given, dict):
            given = self.values.given[_PATH] = {"Value": given}
        self._planned = TrajectoryDisplay(self.stage, self.name, f"{self.root}_path", dict(given))
        self._goal: RobotOverlay | None = None
        self._goal_path: PlannedPath | None = None
        self._goal_besides: Mapping[str, Transform] = {}

    def begin(self) -> None:
        """Subscribe to the scene and to the planned path."""
        super().begin()
        self._planned.begin()

    def end(self) -> None:
        """Unsubscribe from both."""
        self._planned.end()
        super().end()

    def set(self, name: str, value: Any) -> None:
        """Set a property of the scene or of the path."""
        super().set(name, value)
        if name.startswith(f"{_PATH}/"):
            self._planned.set(name.removeprefix(f"{_PATH}/"), value)

    def tick(self) -> None:
        """Animate the path, and draw its goal state."""
        super().tick()
        self._planned.besides = self.robot_poses
        self._planned.follow(jumped_back=False)
        if (self._planned.last_path, self.robot_poses) != (self._goal_path, self._goal_besides):
            self._goal_path, self._goal_besides = self._planned.last_path, self.robot_poses
            self._stand_at_goal()
        if self.status[0] == OK and self._planned.status[0] != OK:
            self.say(*self._planned.status)

    def described(self) -> None:
        """Redraw everything for a new robot description."""
        super().described()
        self._remove_goal()
        self._stand_at_goal()

    def cleared(self) -> None:
        """Remove everything from the scene."""
        super().cleared()
        self._remove_goal()
        self._goal_path = None

    def _stand_at_goal(self) -> None:
        path = self._goal_path
        if path is None or not self.values.flag(f"{_GOAL}/Query Goal State"):
            self._remove_goal()
            return
        if self._goal is None:
            self._goal = self.make_ghost(
                "goal",
                self.values.number(f"{_GOAL}/Goal State Alpha"),
                self.values.color(f"{_GOAL}/Goal State Color"),
            )
        if self._goal is not None:
            self._goal.stand(path.states[-1], self._goal_besides)

    def _remove_goal(self) -> None:
        if self._goal is not None:
            self._goal.remove()
            self._goal = None

"""MoveIt's ``MotionPlanning``: planning scene, animated planned path and goal state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK
from teleopctl.viewer.displays.moveit.base import RobotOverlay
from teleopctl.viewer.displays.moveit.planning_scene import SCENE_PROPERTIES, PlanningScene
from teleopctl.viewer.displays.moveit.trajectory import (
    PATH_PROPERTIES,
    PlannedPath,
    TrajectoryDisplay,
)
from teleopctl.viewer.displays.properties import Property

# Any: messages, whose classes are created from definitions at run time.

# A goal is reached when all links are this near to it, m.
_REACHED_M = 0.01
_PATH = "Planned Path"
_GOAL = "Planning Request"


class MotionPlanning(PlanningScene):
    """MoveIt's ``MotionPlanning`` display: planning scene, animated planned path and goal state.

    The goal is drawn until the robot has reached it. Unlike MoveIt's own, this display has no goal
    to drag and requests no plans: it shows the plans of other programs.
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
        self._reached: PlannedPath | None = None
        self._goal_others: Mapping[str, Transform] = {}

    def begin(self) -> None:
        """Subscribe to the planning scene and to the planned path."""
        super().begin()
        self._planned.begin()

    def end(self) -> None:
        """Unsubscribe from the planning scene and the planned path, and remove both."""
        self._planned.end()
        super().end()

    def set(self, name: str, value: Any) -> None:
        """Set a property; pass one of the group ``Planned Path`` to the path's animation."""
        super().set(name, value)
        if name.startswith(f"{_PATH}/"):
            self._planned.set(name.removeprefix(f"{_PATH}/"), value)

    def tick(self) -> None:
        """Redraw the scene, advance the animation, and draw the goal until it is reached."""
        super().tick()
        others = self.robot_poses
        if not others and (self._goal is not None or self._planned.is_playing):
            others = self.present_poses()
        self._planned.other_poses = others
        self._planned.update(jumped_back=False)
        if (self._planned.last_path, others) != (self._goal_path, self._goal_others):
            self._goal_path, self._goal_others = self._planned.last_path, others
            self._draw_goal()
        if self.status[0] == OK and self._planned.status[0] != OK:
            self.set_status(*self._planned.status)

    def redraw(self) -> None:
        """Redraw the planning scene, its robot and the goal state."""
        super().redraw()
        self._remove_goal()
        self._draw_goal()

    def clear(self) -> None:
        """Remove the planning scene, its robot and the goal state."""
        super().clear()
        self._remove_goal()
        self._goal_path = None

    def _draw_goal(self) -> None:
        path = self._goal_path
        if path is None or not self.values.flag(f"{_GOAL}/Query Goal State"):
            self._remove_goal()
            return
        if path is self._reached:
            return
        if self._goal is None:
            self._goal = self.add_overlay(
                "goal",
                self.values.number(f"{_GOAL}/Goal State Alpha"),
                self.values.color(f"{_GOAL}/Goal State Color"),
            )
        if self._goal is not None:
            self._goal.set_positions(path.states[-1], self._goal_others)
            if not self._planned.is_playing and self._is_there(self._goal):
                self._reached = path
                self._remove_goal()

    def _is_there(self, goal: RobotOverlay) -> bool:
        """Return whether the robot itself, not that of the scene, stands at the goal."""
        present = {} if self.robot_poses else self._goal_others
        return all(
            name in present and math.dist(pose.translation, present[name].translation) < _REACHED_M
            for name, pose in goal.poses.items()
        )

    def _remove_goal(self) -> None:
        if self._goal is not None:
            self._goal.remove()
            self._goal = None

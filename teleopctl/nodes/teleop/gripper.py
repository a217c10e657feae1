"""Gripper driven by teleoperation: a stream of small steps towards a target opening."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING

from teleopctl.commander import (
    CommandPublisher,
    Controller,
    Controllers,
    GripperCommander,
    choose_streams,
    gripper_positions,
)
from teleopctl.errors import TeleopctlError
from teleopctl.robot import Joints

if TYPE_CHECKING:
    from teleopctl.kinematics import RobotGroups
    from teleopctl.node import Node
    from teleopctl.robot import RobotDescription

# Time from open to closed, s; time in which a trajectory controller reaches a step, s.
_WHOLE_S, _AHEAD_S = 1.5, 0.06
# Shortest time between two goals to a gripper that takes no stream, s, and what they differ by.
_GOAL_PERIOD_S, _GOAL_STEP = 0.25, 0.02


def opening_of(
    measured: Mapping[str, float], closed: Mapping[str, float], opened: Mapping[str, float]
) -> float:
    """Return how far a gripper is open, from 0 to 1: the mean of its joints.

    Args:
        measured: Measured positions by joint; a joint that has none counts as closed.
        closed: Closed positions by joint.
        opened: Open positions by joint.
    """
    parts = [
        (measured.get(name, at) - at) / (opened[name] - at)
        for name, at in closed.items()
        if opened[name] != at
    ]
    return min(max(sum(parts) / max(len(parts), 1), 0.0), 1.0)


class GripperDrive:
    """Moves a gripper to a target opening at constant speed, by its active controllers.

    Args:
        node: Node of the commands.
        description: The robot.
        groups: Its groups.
        group: Name of the arm's group, which carries the gripper.

    Attributes:
        wanted: Target opening, 0 (closed) to 1 (open); None before the first command.
        problem: Why it does not move, in words; empty if it does.
    """

    def __init__(
        self, node: Node, description: RobotDescription, groups: RobotGroups, group: str
    ) -> None:
        self._node = node
        self.wanted: float | None = None
        self.problem = ""
        self._commanded: float | None = None
        self._sent: float | None = None
        # Toggled before its opening is known.
        self._is_toggled = False
        self._since_goal_s = _GOAL_PERIOD_S
        self._ends: tuple[dict[str, float], dict[str, float]] | None = None
        self._active: list[Controller] = []
        self._streams: list[CommandPublisher] = []
        self._controllers = Controllers(node, self._on_controllers)
        self._controllers.request()
        self._goals = GripperCommander(node, self._controllers, Joints.of(description))
        # MuJoCo is imported there, which takes a third of a second.
        threading.Thread(
            target=self._find_ends, args=(description, groups, group), daemon=True
        ).start()

    def _find_ends(self, description: RobotDescription, groups: RobotGroups, group: str) -> None:
        # Nothing is rendered; mujoco reads the variable at import.
        os.environ.setdefault("MUJOCO_GL", "disable")
        from teleopctl.kinematics import KinematicModel

        try:
            model = KinematicModel(description)
            closed = gripper_positions(model, groups, group, 0.0)
            opened = gripper_positions(model, groups, group, 1.0)
        except TeleopctlError as error:
            self.problem = f"the gripper is not driven: {error.message}"
            self._node.get_logger().error(self.problem)
            return
        self._ends = closed, opened

    def _on_controllers(self, active: list[Controller]) -> None:
        self._active = active
        self._choose()

    def _choose(self) -> None:
        """Choose the command topics of the active controllers."""
        if self._ends is None:
            return
        topics = choose_streams(self._active, list(self._ends[0]))
        if any(topic.quantity != "position" for topic in topics):
            topics = []
        if topics != [stream.target for stream in self._streams]:
            for stream in self._streams:
                stream.destroy()
            self._streams = [CommandPublisher(self._node, topic, _AHEAD_S) for topic in topics]

    def opening(self, measured: Mapping[str, float]) -> float | None:
        """Return the measured opening, 0 to 1; None if it is unknown."""
        if self._ends is None or not self._ends[0].keys() <= measured.keys():
            return None
        return opening_of(measured, *self._ends)

    def toggle(self) -> None:
        """Set the target to closed if it, or at first the gripper, is open; else to open."""
        if self.wanted is None:
            self._is_toggled = not self._is_toggled
        else:
            self.wanted = 0.0 if self.wanted > 0.5 else 1.0

    def halt(self) -> None:
        """Stop: make the present command the target."""
        self.wanted, self._is_toggled = self._commanded, False

    @property
    def is_done(self) -> bool:
        """Whether the commands have reached the target opening."""
        if self._is_toggled:
            return False
        return self.wanted is None or self._commanded == self.wanted == self._sent

    def step(self, duration_s: float, measured: Mapping[str, float]) -> None:
        """Command the next step towards the target opening.

        Args:
            duration_s: Time since the last step, s.
            measured: Measured positions of all joints.
        """
        at = self.opening(measured)
        if at is None:
            return
        if self._is_toggled:
            self.wanted, self._is_toggled = 0.0 if at > 0.5 else 1.0, False
        if self.wanted is None:
            return
        if self._commanded is None:
            self._commanded = at
        if self._commanded == self.wanted == self._sent:
            return
        by = duration_s / _WHOLE_S
        if self.wanted > self._commanded:
            # Fingers around an object stand short of what was commanded: they open from there.
            self._commanded = min(max(self._commanded, min(at, self.wanted)) + by, self.wanted)
        else:
            self._commanded = max(self._commanded - by, self.wanted)
        self._publish(duration_s, measured)

    def _publish(self, duration_s: float, measured: Mapping[str, float]) -> None:
        assert self._ends is not None and self._commanded is not None and self.wanted is not None
        if not self._streams:
            self._choose()
        if self._streams:
            # A step before the controllers are connected would be lost.
            if not all(stream.is_connected for stream in self._streams):
                self._commanded = self._sent
                return
            positions = self._at(self._commanded)
            for stream in self._streams:
                stream.publish(positions, {}, measured)
            self.problem, self._sent = "", self._commanded
            return
        self._since_goal_s += duration_s
        is_new = self._sent is None or abs(self.wanted - self._sent) > _GOAL_STEP
        if self._since_goal_s < _GOAL_PERIOD_S or not (is_new or self._commanded == self.wanted):
            return
        self._since_goal_s = 0.0
        try:
            self._goals.move(self._at(self.wanted), measured, self._active)
        except TeleopctlError as error:
            self.problem = error.message
            self._controllers.request()
            return
        self.problem, self._sent = "", self.wanted

    def _at(self, opening: float) -> dict[str, float]:
        assert self._ends is not None
        closed, opened = self._ends
        return {name: at + opening * (opened[name] - at) for name, at in closed.items()}

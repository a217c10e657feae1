"""Commands to grippers: how far they open, and motions by whichever controller is active."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.commander.commands import CommandPublisher, RunningMotion
from teleopctl.commander.controllers import (
    Controller,
    Controllers,
    StreamKind,
    choose_controllers,
    choose_streams,
)
from teleopctl.errors import NotFoundError, UsageError
from teleopctl.interfaces import from_seconds, get_message, set_stamp

if TYPE_CHECKING:
    from teleopctl.kinematics import KinematicModel, RobotGroups
    from teleopctl.node import Node
    from teleopctl.robot import Joints

# Part of the velocity limit that is used, speed of joints without one, and shortest motion, s.
_SPEED_PART, _DEFAULT_SPEED, _SHORTEST_S = 0.5, 1.0, 0.2
# Longest time until a controller is connected to a new publisher, s.
_SUBSCRIBER_S = 1.0
_OPENINGS = {"open": 1.0, "close": 0.0, "closed": 0.0}

# Any, here and below: message classes are generated at run time from definitions.


def opening_part(opening: str | float) -> float:
    """Return an opening as a number from 0 (closed) to 1 (open).

    Args:
        opening: ``open``, ``close``, or a number, also as text.

    Raises:
        UsageError: It is none of these.
    """
    try:
        known = _OPENINGS.get(opening) if isinstance(opening, str) else None
        part = float(opening) if known is None else known
    except (TypeError, ValueError):
        part = math.nan
    if not 0.0 <= part <= 1.0:
        raise UsageError(
            "The gripper's opening is open, close or a number from 0 (closed) to 1 (open), "
            f"not {opening!r}"
        )
    return part


def gripper_positions(
    model: KinematicModel, groups: RobotGroups, group: str, part: float
) -> dict[str, float]:
    """Return the positions of a gripper's joints at an opening, rad or m, by name.

    Args:
        model: Model of the robot, whose state is not changed.
        groups: Groups of the robot.
        group: Name of the arm's group, which carries the gripper.
        part: Opening, from 0 (closed) to 1 (open).

    Raises:
        NotFoundError: No gripper of the arm was found.
    """
    from teleopctl.kinematics import gripper_ranges

    gripper = groups.gripper_of(group)
    if gripper is None:
        raise NotFoundError(
            f"The group '{group}' has no gripper",
            hint="An SRDF names it as <end_effector>: teleopctl kinematics srdf --help",
        )
    return {one.joint: one.position(part) for one in gripper_ranges(model, gripper)}


class GripperCommander:
    """Moves a gripper's joints by the actions or the command topics of active controllers.

    Args:
        node: Node of the endpoints.
        controllers: Clients of the controllers.
        joints: Joints of the robot, for their velocity limits.
    """

    def __init__(self, node: Node, controllers: Controllers, joints: Joints) -> None:
        self._node, self._controllers, self._joints = node, controllers, joints
        self._publishers: dict[str, CommandPublisher] = {}

    def move(
        self,
        positions: Mapping[str, float],
        measured: Mapping[str, float],
        available: Sequence[Controller],
    ) -> RunningMotion:
        """Command positions; return the goals that were sent, none for command topics.

        Args:
            positions: Positions by joint, rad or m.
            measured: Measured positions of all joints.
            available: Controllers that can be used.

        Raises:
            NotFoundError: No active controller moves a joint; nothing is sent.
        """
        chosen, left = choose_controllers(list(positions), available)
        arrays = [one for one in available if one.stream and one.stream.kind is StreamKind.ARRAY]
        topics = choose_streams(arrays, left)
        if left and (not topics or any(topic.quantity != "position" for topic in topics)):
            raise NotFoundError(f"No active controller moves {', '.join(left)} to positions")
        motion = RunningMotion.of(
            self._controllers, chosen, self._trajectory(positions, measured), measured
        )
        for topic in topics if left else ():
            if topic.topic not in self._publishers:
                made = CommandPublisher(self._node, topic, 0.0)
                made.wait_for_subscriber(_SUBSCRIBER_S)
                self._publishers[topic.topic] = made
            self._publishers[topic.topic].publish(positions, {}, measured)
        return motion

    def _trajectory(self, positions: Mapping[str, float], measured: Mapping[str, float]) -> Any:
        """Return a motion to positions within the joints' velocity limits, as a JointTrajectory."""
        duration_s = _SHORTEST_S
        for name, position in positions.items():
            limit = self._joints[name].limits.velocity
            speed = _SPEED_PART * limit if math.isfinite(limit) else _DEFAULT_SPEED
            duration_s = max(duration_s, abs(position - measured.get(name, position)) / speed)
        point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")(
            positions=list(positions.values())
        )
        set_stamp(point.time_from_start, from_seconds(duration_s))
        return get_message("trajectory_msgs/msg/JointTrajectory")(
            joint_names=list(positions), points=[point]
        )

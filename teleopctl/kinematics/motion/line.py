"""Straight lines of the tool: poses in small steps, inverse kinematics from one to the next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.error_codes import MoveItErrorCode
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.motion.search import touching_text
from teleopctl.kinematics.poses import Array, rotation_matrix, rotation_vector
from teleopctl.kinematics.solver import IkSolver, PoseTask, Tolerance, check_pose, served_task

# Rotation (rad) that counts as a step of one metre, as MoveIt's MaxEEFStep has it: 2° for 1 cm.
_RAD_PER_M = 3.5
# Steps of a line whose average a jump is compared with, as in MoveIt.
_LEAST_STEPS = 10
# Steps of a line at most: some ten seconds of inverse kinematics.
_MOST_STEPS = 20_000
# Deviation half-way between two solutions from which another one is put between, and how often.
_DEVIATION_M, _DEVIATION_RAD, _DEEPEST = 2e-4, 2e-3, 6
# Errors of inverse kinematics of a whole pose: noise in them would be noise of accelerations.
_EXACT = Tolerance(1e-7, 1e-7)


@dataclass(frozen=True, slots=True)
class JointJump:
    """Step of the joints that counts as a jump; 0 allows all.

    Attributes:
        factor: As a multiple of the average distance between consecutive solutions.
        revolute: Of a revolute joint, rad.
        prismatic: Of a prismatic joint, m.
    """

    factor: float = 0.0
    revolute: float = 0.0
    prismatic: float = 0.0


@dataclass(frozen=True, slots=True)
class CartesianPath:
    """Joint positions along straight lines of the tool.

    Attributes:
        positions: Positions, (m, n), from the start; straight motions of the joints between them
            stay near the lines.
        fraction: Part of the poses that is reached, 0 to 1, as MoveIt counts it.
        corners: Numbers of the positions at which a pose of the caller is reached.
        code: ``SUCCESS``, or MoveIt's code for what ended the path.
        reason: What ended the path, in a sentence; empty if nothing did.
    """

    positions: Array
    fraction: float
    corners: tuple[int, ...]
    code: MoveItErrorCode = MoveItErrorCode.SUCCESS
    reason: str = ""


def compute_cartesian_path(
    kinematics: GroupKinematics,
    start: Array,
    poses: Sequence[Array],
    *,
    max_step_m: float = 0.01,
    jump: JointJump | None = None,
    task: PoseTask | None = None,
    edges: EdgeChecker | None = None,
) -> CartesianPath:
    """Return joint positions with which the tool moves on straight lines through poses.

    The origin moves linearly, the rotation about one axis (slerp). A path that cannot continue is
    returned as far as it goes.

    Args:
        kinematics: Kinematics of the group.
        start: Positions from which the path begins, (n,), rad or m.
        poses: Poses of the tool in the root link's frame, (4, 4) each.
        max_step_m: Largest distance between two solutions, m; of rotations 3.5 times as much, rad.
        jump: Steps of the joints that end the path; None for none.
        task: What of the poses is served; None for what the joints allow.
        edges: Checker of collisions; None to check none.

    Raises:
        UsageError: The step or a threshold is negative, or a pose is no pose.
    """
    jump = jump or JointJump()
    if not max_step_m > 0.0 or min(jump.factor, jump.revolute, jump.prismatic) < 0.0:
        raise UsageError(
            f"A Cartesian path needs max_step above 0, and jump thresholds of at least 0, not "
            f"{max_step_m:g}, {jump.factor:g}, {jump.revolute:g} and {jump.prismatic:g}"
        )
    for pose in poses:
        check_pose(pose)
    task = served_task(kinematics) if task is None else task
    tolerance = _EXACT if task is PoseTask.POSE else Tolerance()
    walk = _Walk(kinematics, IkSolver(kinematics, task=task, tolerance=tolerance), edges, jump)
    positions, corners = [start], []
    fraction = 0.0
    for number, pose in enumerate(poses):
        kinematics.set(positions[-1])
        states, part = walk.line(positions[-1], kinematics.pose(), pose, max_step_m)
        positions += states
        fraction = (number + part) / len(poses)
        if part < 1.0:
            break
        corners.append(len(positions) - 1)
    if jump.factor > 0.0 and (place := _relative_jump(np.array(positions), jump.factor)):
        fraction *= place / len(positions)
        positions = positions[:place]
        corners = [corner for corner in corners if corner < place]
        walk.ended = (
            MoveItErrorCode.PLANNING_FAILED,
            f"the joints jump by more than {jump.factor:g} average steps",
        )
    kinematics.set(start)
    code, reason = walk.ended or (MoveItErrorCode.SUCCESS, "")
    return CartesianPath(np.array(positions), fraction, tuple(corners), code, reason)


class _Walk:
    """Steps of inverse kinematics along lines, and what ended them."""

    def __init__(
        self,
        kinematics: GroupKinematics,
        solver: IkSolver,
        edges: EdgeChecker | None,
        jump: JointJump,
    ) -> None:
        self.ended: tuple[MoveItErrorCode, str] | None = None
        self._kinematics, self._solver, self._edges = kinematics, solver, edges
        self._least_steps = _LEAST_STEPS if jump.factor > 0.0 else 1
        joints = kinematics.model.description.joints
        slides = np.array([joints[name].type == "prismatic" for name in kinematics.names])
        largest = np.where(slides, jump.prismatic, jump.revolute)
        self._largest = np.where(largest > 0.0, largest, np.inf)

    def line(
        self, start: Array, T_root_start: Array, T_root_end: Array, max_step_m: float
    ) -> tuple[list[Array], float]:
        """Return the states after the start up to a pose, and the part of the line, 0 to 1."""
        way = float(np.linalg.norm(T_root_end[:3, 3] - T_root_start[:3, 3]))
        turn = rotation_vector(T_root_start[:3, :3].T @ T_root_end[:3, :3])
        angle = float(np.linalg.norm(turn)) if self._solver.task is PoseTask.POSE else 0.0
        steps = 1 + math.floor(max(way, angle / _RAD_PER_M) / max_step_m - 1e-9)
        if steps > _MOST_STEPS:
            raise UsageError(
                f"A line of {way:.3g} m and {angle:.3g} rad has {steps} steps of {max_step_m:g} m, "
                f"more than {_MOST_STEPS}",
                hint="Allow longer steps: where more are needed to stay on the line, they are "
                "added.",
            )
        steps = max(steps, self._least_steps)
        line = _Line(T_root_start, T_root_end, turn)
        states: list[Array] = []
        before, reached = start, 0.0
        for number in range(1, steps + 1):
            part = number / steps
            added = self._step(line, before, reached, part, 0)
            if added is None:
                return states, reached
            states += added
            before, reached = added[-1], part
        return states, 1.0

    def _step(
        self, line: _Line, before: Array, low: float, high: float, depth: int
    ) -> list[Array] | None:
        """Return the states after one state up to a part of a line, or None if there are none."""
        kinematics = self._kinematics
        target = line.pose(high)
        found = self._solver.solve(target, before, most_starts=1)
        if not found.is_reached:
            self.ended = (MoveItErrorCode.NO_IK_SOLUTION, "; ".join(found.binding))
            return None
        state = found.positions
        if (np.abs(state - before) > self._largest).any():
            place = int(np.argmax(np.abs(state - before) / self._largest))
            self.ended = (
                MoveItErrorCode.PLANNING_FAILED,
                f"joint '{kinematics.names[place]}' jumps by {abs(state - before)[place]:.3g}",
            )
            return None
        kinematics.set(0.5 * (before + state))
        middle = 0.5 * (low + high)
        if not line.is_near(kinematics.pose(), middle, self._solver.task):
            if depth == _DEEPEST:
                self.ended = (
                    MoveItErrorCode.PLANNING_FAILED,
                    "the joints would have to jump: the arm is at a singularity",
                )
                return None
            first = self._step(line, before, low, middle, depth + 1)
            if first is None:
                return None
            second = self._step(line, first[-1], middle, high, depth + 1)
            return None if second is None else first + second
        edges = self._edges
        if edges and not (edges.is_free(state) and edges.is_edge_free(before, state)):
            at = before + edges.free_part(before, state) * (state - before)
            text = touching_text(edges, state) or touching_text(edges, at)
            self.ended = (
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f"collision of {text}" if text else "the constraints of the path are not met",
            )
            return None
        return [state]


@dataclass(frozen=True, slots=True)
class _Line:
    """Line between two poses."""

    T_root_start: Array
    T_root_end: Array
    turn: Array

    def pose(self, part: float) -> Array:
        """Return the pose at a part of the line, 0 to 1."""
        if part >= 1.0:
            return self.T_root_end
        pose = np.eye(4)
        pose[:3, :3] = self.T_root_start[:3, :3] @ rotation_matrix(part * self.turn)
        pose[:3, 3] = (1.0 - part) * self.T_root_start[:3, 3] + part * self.T_root_end[:3, 3]
        return pose

    def is_near(self, pose: Array, part: float, task: PoseTask) -> bool:
        """Return whether a pose is near that at a part of the line."""
        target = self.pose(part)
        if float(np.linalg.norm(pose[:3, 3] - target[:3, 3])) > _DEVIATION_M:
            return False
        if task is not PoseTask.POSE:
            return True
        turn = rotation_vector(pose[:3, :3].T @ target[:3, :3])
        return float(np.linalg.norm(turn)) <= _DEVIATION_RAD


def _relative_jump(positions: Array, factor: float) -> int | None:
    """Return the number of the state that a jump leads to, or None without one."""
    if len(positions) < 2:
        return None
    distances = np.abs(np.diff(positions, axis=0)).sum(axis=1)
    jumps = np.flatnonzero(distances > factor * float(distances.mean()))
    return int(jumps[0]) + 1 if len(jumps) else None

"""Conversion of goal constraints to joint positions or poses of a link."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from teleopctl.kinematics import (
    ClearanceChecker,
    GroupKinematics,
    IkSolution,
    IkSolver,
    MoveItErrorCode,
    PlanningError,
    PoseTask,
    Tolerance,
    rotation_matrix,
)
from teleopctl.nodes.moveit.move_group.constraints import ConstraintSet, Orientation

# Errors below which a goal counts as reached although its tolerance is smaller: those of the
# solver, m and rad.
_LEAST_POSITION_M, _LEAST_ROTATION_RAD = 1e-4, 1e-3
# Errors that are aimed at where the tolerance allows more.
_FINE_POSITION_M, _FINE_ROTATION_RAD = 1e-3, 1e-2
# Tolerance of a rotation, rad, from which other rotations within it are tried.
_WIDE_RAD = 0.1
# Most rotations that are tried, and solutions that are handed to the planner.
_MOST_ROTATIONS, _MOST_SOLUTIONS = 48, 8


@dataclass(frozen=True)
class PoseGoal:
    """Goal pose of a link.

    Attributes:
        targets: Poses of the link, or of the tool beside its origin, in the root link's frame,
            (4, 4), the requested one first, then others within the tolerances.
        task: What of the pose is served; None for what the group's joints allow.
        tolerance: Largest errors.
    """

    targets: tuple[np.ndarray, ...]
    task: PoseTask | None
    tolerance: Tolerance


# Any: message classes are generated at run time from definitions.
def goal_link(message: Any) -> str:
    """Return the link that the position and orientation constraints of a goal are about.

    Raises:
        PlanningError: They are about several links.
    """
    links = {
        one.link_name for one in (*message.position_constraints, *message.orientation_constraints)
    }
    if len(links) > 1:
        raise PlanningError(
            f"A goal for several links at once is not supported: {', '.join(sorted(links))}",
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
        )
    return next(iter(links), "")


def joint_goal(
    constraints: ConstraintSet, kinematics: GroupKinematics, start: np.ndarray
) -> np.ndarray:
    """Return the positions of a goal of joint constraints, (n,); other joints stay.

    Raises:
        PlanningError: A joint is not of the group, or no position within the tolerances is within
            the joint's limits.
    """
    goal = np.array(start)
    joints = kinematics.model.joints
    for name, (position, below, above) in constraints.joints.items():
        if name not in kinematics.names:
            if name in joints and joints[name].mimic is not None:
                continue
            raise PlanningError(
                f"The group '{kinematics.group.name}' has no joint '{name}': its joints are "
                f"{', '.join(kinematics.names)}",
                MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            )
        place = kinematics.names.index(name)
        limit = kinematics.limits[place]
        lower, upper = float(kinematics.lower[place]), float(kinematics.upper[place])
        inside = min(max(position, lower), upper)
        if not position - below - 1e-9 <= inside <= position + above + 1e-9:
            word = "below its lower" if position < lower else "above its upper"
            raise PlanningError(
                f"The goal of joint '{name}', {position:.4g}, is {word} limit "
                f"{lower if position < lower else upper:.4g}",
                MoveItErrorCode.GOAL_STATE_INVALID,
            )
        if limit.angle_wraparound:
            turns = round((float(start[place]) - inside) / (2.0 * math.pi))
            inside += 2.0 * math.pi * turns
        goal[place] = inside
    return goal


def pose_goal(constraints: ConstraintSet, kinematics: GroupKinematics) -> PoseGoal:
    """Return the pose of a goal of position and orientation constraints.

    Without an orientation the link's position is served, without a position its orientation where
    it is now. A point beside the link's origin becomes the tool of the kinematics: where the joints
    do not serve the rotation, its place depends on what the rotation comes to.

    Raises:
        PlanningError: There are several constraints of a kind.
    """
    if len(constraints.regions) > 1 or len(constraints.orientations) > 1:
        raise PlanningError(
            "A goal with several positions or orientations of a link is not supported",
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
        )
    if constraints.regions and constraints.regions[0].offset.any():
        tool = np.eye(4)
        tool[:3, 3] = constraints.regions[0].offset
        kinematics.set_tool(kinematics.T_tip_tool @ tool)
    present = kinematics.pose()
    orientation = constraints.orientations[0] if constraints.orientations else None
    rotation = present[:3, :3] if orientation is None else orientation.rotation
    position_m, place = math.inf, present[:3, 3]
    if constraints.regions:
        region = constraints.regions[0]
        place = region.centre
        position_m = max(region.tolerance_m, _LEAST_POSITION_M)
    rotation_rad = (
        math.inf
        if orientation is None
        else max(float(orientation.tolerances.min()), _LEAST_ROTATION_RAD)
    )
    targets = []
    for turned in _rotations(rotation, orientation):
        target = np.eye(4)
        target[:3, :3] = turned
        target[:3, 3] = place
        targets.append(target)
    return PoseGoal(
        tuple(targets),
        PoseTask.POSITION if orientation is None else None,
        Tolerance(min(position_m, _FINE_POSITION_M), min(rotation_rad, _FINE_ROTATION_RAD)),
    )


def solutions(
    goal: PoseGoal,
    kinematics: GroupKinematics,
    start: np.ndarray,
    clearance: ClearanceChecker | None,
    task: PoseTask,
    path: ConstraintSet,
) -> list[np.ndarray]:
    """Return positions, (n,) each, at which a goal and the constraints of the path are met.

    Raises:
        PlanningError: There are none; with the nearest pose, and what binds.
    """
    found: list[np.ndarray] = []
    solver = IkSolver(
        kinematics, task=goal.task or task, tolerance=goal.tolerance, clearance=clearance
    )
    nearest = None
    against_path = ""
    generator = np.random.default_rng(0)
    for target in goal.targets:
        begin = start
        for _ in range(_MOST_SOLUTIONS if len(goal.targets) == 1 else 1):
            solved = solver.solve(target, begin)
            if nearest is None or solved.position_error_m < nearest.position_error_m:
                nearest = solved
            if not solved.is_reached:
                break
            against_path = path.violation(solved.positions)
            if not against_path and not any(
                np.abs(solved.positions - one).max() < 1e-2 for one in found
            ):
                found.append(solved.positions)
            begin = kinematics.random(generator)
        if len(found) >= _MOST_SOLUTIONS:
            break
    kinematics.set(start)
    if found:
        return found
    assert nearest is not None
    if against_path:
        raise PlanningError(
            f"The goal violates the path constraints: {against_path}",
            MoveItErrorCode.GOAL_VIOLATES_PATH_CONSTRAINTS,
        )
    problem, is_collision = unreached(solver, goal.targets[0], start, nearest)
    kinematics.set(start)
    code = MoveItErrorCode.GOAL_IN_COLLISION if is_collision else MoveItErrorCode.NO_IK_SOLUTION
    raise PlanningError(problem, code)


def unreached(
    solver: IkSolver, target: np.ndarray, start: np.ndarray, nearest: IkSolution
) -> tuple[str, bool]:
    """Return why a pose is not reached, as a sentence, and whether only collisions keep it.

    Args:
        solver: Solver that has not reached it.
        target: The pose in the root link's frame, (4, 4).
        start: Positions from which the search began, (n,).
        nearest: The nearest that it found.
    """
    kinematics, clearance = solver.kinematics, solver.clearance
    tip = kinematics.group.tip
    if clearance is not None:
        alone = IkSolver(kinematics, task=solver.task, tolerance=solver.tolerance)
        found = alone.solve(target, start)
        if found.is_reached:
            kinematics.set(found.positions)
            touching = [
                f"'{first}' and '{second}'"
                for first, second in (one.bodies for one in clearance.collisions())
            ]
            return f"At the pose of '{tip}' {', '.join(touching[:3])} would collide", True
        nearest = found
    why = "; ".join(nearest.binding) or "the arm is too short"
    return (
        f"'{tip}' cannot reach the pose: the nearest is {1e3 * nearest.position_error_m:.1f} mm "
        f"and {nearest.rotation_error_rad:.3f} rad away ({why})"
    ), False


def _rotations(rotation: np.ndarray, orientation: Orientation | None) -> Iterator[np.ndarray]:
    """Yield a rotation, and others within its tolerances where these are wide."""
    yield rotation
    if orientation is None:
        return
    axes = []
    for tolerance in orientation.tolerances.tolist():
        if tolerance < _WIDE_RAD:
            axes.append([0.0])
        elif tolerance >= math.pi:
            axes.append(
                [math.pi * step / 6.0 for step in (0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6)]
            )
        else:
            axes.append([0.0, 0.5 * tolerance, -0.5 * tolerance, 0.9 * tolerance, -0.9 * tolerance])
    combined = sorted(itertools.product(*axes), key=lambda turn: sum(map(abs, turn)))
    for x, y, z in combined[1:_MOST_ROTATIONS]:
        if orientation.is_vector:
            yield rotation @ rotation_matrix(np.array((x, y, z)))
        else:
            turned = rotation
            for axis, angle in enumerate((x, y, z)):
                vector = np.zeros(3)
                vector[axis] = angle
                turned = turned @ rotation_matrix(vector)
            yield turned

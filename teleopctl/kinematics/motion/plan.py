"""Plans of motion from a start to a joint goal, to a pose, or along a straight line of the tool."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from teleopctl.errors import UsageError
from teleopctl.kinematics.error_codes import MoveItErrorCode, PlanningError
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.motion.edges import EdgeChecker, StateCondition
from teleopctl.kinematics.motion.limits import MotionLimits
from teleopctl.kinematics.motion.line import JointJump, compute_cartesian_path
from teleopctl.kinematics.motion.path import JointPath, distinct
from teleopctl.kinematics.motion.planner_names import choose_planner
from teleopctl.kinematics.motion.search import (
    FoundPath,
    check_positions,
    find_path,
    touching_text,
)
from teleopctl.kinematics.motion.shortcut import shorten
from teleopctl.kinematics.motion.timing import (
    MOST_POINTS,
    TimeLaw,
    fastest_law,
    sampled,
    smoothed_law,
    within_limits,
)
from teleopctl.kinematics.poses import Array
from teleopctl.kinematics.solver import IkSolution, IkSolver

if TYPE_CHECKING:
    from teleopctl.kinematics.clearance import ClearanceChecker
    from teleopctl.kinematics.solver import PoseTask, Tolerance

# Part of the time for a search that may be spent on making its path shorter.
_SHORTEN = 0.2
# Attempts at rounding the corners, by how much a corner is rounded less where the motion touches,
# and the part of the path tolerance below which it is stopped at.
_ROUNDS, _CLOSER, _SMALLEST = 12, 0.3, 0.02
# Time, s, between the points of a motion at which collisions are checked.
_CHECK_S = 0.005
# Angle (rad) between the steps of the joints at a pose of a line, from which the motion stops
# there.
_CORNER_RAD = 0.35
# Solutions of inverse kinematics that are goals of one search, the starts for them, and the
# difference (rad or m) from which two are not the same.
_MOST_GOALS, _STARTS, _DIFFERENT = 4, 12, 0.1


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """Settings of a plan.

    Attributes:
        planner: Name of the planner, as OMPL names it (``RRTConnect``, ``RRTstar``, ``PRM``, …);
            empty for RRTConnect.
        library: ``ompl``, ``teleopctl`` for the planner of our own, or empty for OMPL where it is
            installed.
        timeout_s: Time for the search of a path, MoveIt's ``allowed_planning_time``, s.
        velocity_scaling: Part of the velocity limits that is used, above 0 to 1.
        acceleration_scaling: Part of the acceleration and jerk limits that is used, above 0 to 1.
        limits: Limits of the joints before scaling; None for those of the robot's description.
        path_tolerance: Largest distance from the path at its rounded corners, rad or m of each
            joint; 0 to stop at each waypoint.
        period_s: Time between the points of the plan, s.
        seed: Start of the random numbers; the same seed gives the same path.
        parameters: Parameters of the planner by OMPL's names, such as ``range``.
        is_canceled: Called at each checked state, returns whether to end; planning then raises
            a PlanningError with the code PREEMPTED.

    Example:
        >>> from teleopctl import Arm, MotionSettings
        >>> arm = Arm("package://teleop_description/urdf/teleop.urdf.xacro")
        >>> slow = arm.plan([0.5, 0.2, -0.3], settings=MotionSettings(velocity_scaling=0.1))
        >>> slow.duration_s > arm.plan([0.5, 0.2, -0.3]).duration_s
        True
    """

    planner: str = ""
    library: str = ""
    timeout_s: float = 5.0
    velocity_scaling: float = 1.0
    acceleration_scaling: float = 1.0
    limits: MotionLimits | None = None
    path_tolerance: float = 0.05
    period_s: float = 0.01
    seed: int = 0
    parameters: Mapping[str, str] = field(default_factory=dict)
    is_canceled: Callable[[], bool] | None = None


@dataclass(frozen=True, slots=True)
class MotionPlan:
    """Timed motion of a group's independent joints, as points of a ``JointTrajectory``.

    Attributes:
        joint_names: Names of the independent joints, n of them; mimic joints follow by themselves.
        times: Time of each point from the start, (k,), s; the first is 0.
        positions: Positions at the points, (k, n), rad or m.
        velocities: Velocities at the points, (k, n), rad/s or m/s; 0 at the first and the last.
        accelerations: Accelerations at the points, (k, n), rad/s² or m/s².
        planner: Library and name of the planner, such as ``OMPL RRTConnect``.
        computing_s: Time that planning took, s.
        duration_before_jerk_s: Duration under the limits of velocity and acceleration alone, s.
        waypoints: The path that is followed: corners, or points of the line, (m, n).
        fraction: Part of a line that is reached, 0 to 1; 1 for other motions.
        notes: Notes for the caller, one sentence each, such as a start that was left.
    """

    joint_names: tuple[str, ...]
    times: Array
    positions: Array
    velocities: Array
    accelerations: Array
    planner: str
    computing_s: float
    duration_before_jerk_s: float
    waypoints: Array
    fraction: float = 1.0
    notes: tuple[str, ...] = field(default=())

    @property
    def duration_s(self) -> float:
        """Duration of the motion, s."""
        return float(self.times[-1])


def plan_to_joints(
    kinematics: GroupKinematics,
    start: Array,
    goals: Array | Sequence[Array],
    *,
    clearance: ClearanceChecker | None = None,
    condition: StateCondition | None = None,
    settings: MotionSettings | None = None,
) -> MotionPlan:
    """Plan a motion to positions of the joints.

    The model's other joints stay as they are; the model is at the start again afterwards.

    Args:
        kinematics: Kinematics of the group.
        start: Present positions of the independent joints, (n,), rad or m.
        goals: Positions to reach, (n,), or several of them, of which any will do.
        clearance: Checker of collisions; None to check none.
        condition: Condition on all positions of the path, such as an orientation to be kept.
        settings: Settings.

    Raises:
        PlanningError: There is no such motion, or none was found in time; with MoveIt's code.
        UsageError: A setting is invalid.
    """
    began = time.monotonic()
    settings = settings or MotionSettings()
    start = check_positions(kinematics, start, "start")
    listed = [goals] if np.ndim(goals) == 1 else list(goals)
    wanted = np.array([check_positions(kinematics, np.asarray(goal), "goal") for goal in listed])
    limits = _limits(kinematics, settings)
    planner, notes = choose_planner(settings.planner, settings.library)
    edges = EdgeChecker(kinematics, clearance, condition, is_canceled=settings.is_canceled)
    try:
        found = find_path(
            edges,
            planner,
            start,
            wanted,
            timeout_s=settings.timeout_s,
            seed=settings.seed,
            parameters=settings.parameters,
        )
        shorter = found.corners[found.first :]
        if not found.is_curve:
            shorter = shorten(
                edges, shorter, seed=settings.seed, timeout_s=_SHORTEN * settings.timeout_s
            )
        elif settings.planner:
            notes = (*notes, f"{found.planner} keeps the path's constraints, not {planner.text}")
        parts = _legs(edges, found, shorter, limits, settings)
    finally:
        kinematics.set(start)
    return _joined(
        kinematics,
        parts,
        settings,
        planner=found.planner,
        began=began,
        waypoints=np.vstack((found.corners[: found.first], shorter)),
        notes=(*notes, *limits.assumed, *found.notes),
    )


def plan_to_pose(
    kinematics: GroupKinematics,
    start: Array,
    T_root_tool: Array,
    *,
    task: PoseTask | None = None,
    tolerance: Tolerance | None = None,
    clearance: ClearanceChecker | None = None,
    condition: StateCondition | None = None,
    settings: MotionSettings | None = None,
) -> MotionPlan:
    """Plan a motion to a pose of the tool.

    Args:
        kinematics: Kinematics of the group.
        start: Present positions of the independent joints, (n,), rad or m.
        T_root_tool: Pose to reach in the root link's frame, (4, 4).
        task: What of the pose is served; None for what the joints allow.
        tolerance: Errors at which the pose counts as reached.
        clearance: Checker of collisions; None to check none.
        condition: Condition on all positions of the path.
        settings: Settings.

    Raises:
        PlanningError: As `plan_to_joints`; without a solution, code -31 and what binds.
        UsageError: A setting or the pose is invalid.
    """
    began = time.monotonic()
    settings = settings or MotionSettings()
    start = check_positions(kinematics, start, "start")
    solver = IkSolver(kinematics, task=task, tolerance=tolerance, clearance=clearance)
    try:
        edges = EdgeChecker(kinematics, clearance, condition, is_canceled=settings.is_canceled)
        goals = _solutions(solver, edges, T_root_tool, start, settings)
    finally:
        kinematics.set(start)
    plan = plan_to_joints(
        kinematics, start, goals, clearance=clearance, condition=condition, settings=settings
    )
    return replace(plan, computing_s=time.monotonic() - began)


def plan_line(
    kinematics: GroupKinematics,
    start: Array,
    poses: Sequence[Array],
    *,
    max_step_m: float = 0.01,
    jump_factor: float = 0.0,
    jump_rad: float = 0.0,
    jump_m: float = 0.0,
    task: PoseTask | None = None,
    clearance: ClearanceChecker | None = None,
    condition: StateCondition | None = None,
    settings: MotionSettings | None = None,
    least_fraction: float = 1.0,
) -> MotionPlan:
    """Plan a motion of the tool on straight lines through poses.

    The motion stops at a pose where the joints' direction changes by more than 20°; elsewhere it
    passes smoothly, within 1 mm of the lines.

    Args:
        kinematics: Kinematics of the group.
        start: Present positions of the independent joints, (n,), rad or m.
        poses: Poses of the tool in the root link's frame, (4, 4) each.
        max_step_m: Largest distance between two solutions of inverse kinematics, m.
        jump_factor: Step of the joints that counts as a jump, in average steps; 0 to allow all.
        jump_rad: Step of a revolute joint that counts as a jump, rad; 0 to allow all.
        jump_m: Step of a prismatic joint that counts as a jump, m; 0 to allow all.
        task: What of the poses is served; None for what the joints allow.
        clearance: Checker of collisions; None to check none.
        condition: Condition on all positions of the path.
        settings: Settings.
        least_fraction: Part of the lines that must be reached, 0 to 1.

    Raises:
        PlanningError: Less than that part can be followed; with MoveIt's code and what ended it.
        UsageError: A setting or a pose is invalid.
    """
    began = time.monotonic()
    settings = settings or MotionSettings()
    start = check_positions(kinematics, start, "start")
    limits = _limits(kinematics, settings)
    edges = EdgeChecker(kinematics, clearance, condition, is_canceled=settings.is_canceled)
    edges.loosen(start)
    try:
        if not edges.is_free(start):
            text = touching_text(edges, start)
            raise PlanningError(
                f"The start is in collision: {text}"
                if text
                else "The start does not meet the constraints of the path",
                MoveItErrorCode.START_STATE_IN_COLLISION
                if text
                else MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS,
            )
        path = compute_cartesian_path(
            kinematics,
            start,
            poses,
            max_step_m=max_step_m,
            jump=JointJump(jump_factor, jump_rad, jump_m),
            task=task,
            edges=edges,
        )
        if path.fraction < least_fraction:
            raise PlanningError(
                f"The line can be followed to {100.0 * path.fraction:.0f} %: {path.reason}",
                path.code,
            )
        legs = [
            _smooth(JointPath.spline(points, limits.velocities), limits, settings, keeps_path=True)
            for points in _split(path.positions, path.corners, limits)
            if len(distinct(points)) > 1
        ]
    finally:
        kinematics.set(start)
    ended = (f"The line ends at {100.0 * path.fraction:.0f} %: {path.reason}",)
    return _joined(
        kinematics,
        legs,
        settings,
        planner="teleopctl line",
        began=began,
        waypoints=path.positions,
        notes=(*(ended if path.reason else ()), *limits.assumed),
        fraction=path.fraction,
    )


@dataclass(frozen=True, slots=True)
class _Leg:
    """Motion from rest to rest, with its duration before jerk was limited, s."""

    law: TimeLaw
    before_jerk_s: float


def _limits(kinematics: GroupKinematics, settings: MotionSettings) -> MotionLimits:
    for name, value, least in (
        ("time for the search", settings.timeout_s, 0.0),
        ("path tolerance", settings.path_tolerance, -1e-300),
        ("period", settings.period_s, 0.0),
    ):
        if not (value > least and math.isfinite(value)):
            raise UsageError(f"The {name} is {value:g}, and must be a finite number above 0")
    limits = settings.limits or MotionLimits.of(kinematics)
    return limits.scaled(settings.velocity_scaling, settings.acceleration_scaling)


def _legs(
    edges: EdgeChecker,
    found: FoundPath,
    corners: Array,
    limits: MotionLimits,
    settings: MotionSettings,
) -> list[_Leg]:
    """Return the motions of a path: out of a collision to rest, then to the goal."""
    out = found.corners[: found.first + 1]
    legs = []
    if found.first:
        way = JointPath.spline(out, limits.velocities)
        legs.append(_smooth(way, limits, settings, keeps_path=True))
    corners = distinct(corners)
    if len(corners) < 2:
        return legs
    if found.is_curve:
        curve = _smooth(
            JointPath.spline(corners, limits.velocities), limits, settings, keeps_path=True
        )
        if _touch(edges, curve.law) is None:
            return [*legs, curve]
    tolerances = np.full(len(corners) - 2, settings.path_tolerance)
    for _ in range(_ROUNDS):
        leg = _smooth(JointPath.rounded(corners, limits.velocities, tolerances), limits, settings)
        touching = _touch(edges, leg.law)
        if touching is None:
            return [*legs, leg]
        if not tolerances.any():
            break
        # The nearest corner that is still rounded passes closer by its polyline.
        distances = np.linalg.norm((corners[1:-1] - touching) / limits.velocities, axis=1)
        nearest = int(np.argmin(np.where(tolerances > 0.0, distances, np.inf)))
        smaller = _CLOSER * float(tolerances[nearest])
        tolerances[nearest] = smaller if smaller > _SMALLEST * settings.path_tolerance else 0.0
    exact = _stopping(corners, limits, settings)
    for leg in exact:
        touching = _touch(edges, leg.law)
        if touching is not None:
            raise PlanningError(
                f"The timed path touches: {touching_text(edges, touching)}",
                MoveItErrorCode.INVALID_MOTION_PLAN,
            )
    return [*legs, *exact]


def _stopping(corners: Array, limits: MotionLimits, settings: MotionSettings) -> list[_Leg]:
    """Return a motion that follows a polyline exactly, with a stop at each corner."""
    return [
        _smooth(
            JointPath.rounded(corners[place : place + 2], limits.velocities, 0.0), limits, settings
        )
        for place in range(len(corners) - 1)
    ]


def _smooth(
    path: JointPath, limits: MotionLimits, settings: MotionSettings, *, keeps_path: bool = False
) -> _Leg:
    law = fastest_law(path, limits)
    smooth = smoothed_law(law, limits, keeps_path=keeps_path, period_s=settings.period_s)
    return _Leg(smooth, within_limits(law, limits).duration_s)


def _touch(edges: EdgeChecker, law: TimeLaw) -> Array | None:
    """Return positions of a motion that are in collision, (n,), or None."""
    if edges.clearance is None and edges.condition is None:
        return None
    period_s = max(_CHECK_S, 2.0 * law.duration_s / MOST_POINTS)
    positions = sampled(law, period_s).positions
    place = edges.touch_on_curve(positions)
    return None if place is None else positions[place]


def _split(positions: Array, corners: Sequence[int], limits: MotionLimits) -> list[Array]:
    """Return the parts of a line's joint positions between the corners at which it has to stop."""
    steps = np.diff(positions, axis=0) / limits.velocities
    ends = [0]
    for corner in corners:
        if 0 < corner < len(steps):
            before, after = steps[corner - 1], steps[corner]
            sizes = float(np.linalg.norm(before) * np.linalg.norm(after))
            if float(before @ after) < math.cos(_CORNER_RAD) * sizes:
                ends.append(corner)
    ends.append(len(positions) - 1)
    return [positions[first : last + 1] for first, last in pairwise(ends)]


def _solutions(
    solver: IkSolver,
    edges: EdgeChecker,
    T_root_tool: Array,
    start: Array,
    settings: MotionSettings,
) -> list[Array]:
    """Return solutions of inverse kinematics that differ, the first one near the start.

    It is the only one if the straight motion to it is free.
    """
    kinematics = solver.kinematics
    first = solver.solve(T_root_tool, start, timeout_s=settings.timeout_s)
    if not first.is_reached:
        raise _unreachable(first)
    found = [_unwound(kinematics, first.positions, start)]
    edges.loosen(start, found[0])
    if all(map(edges.is_free, (start, found[0]))) and edges.is_edge_free(start, found[0]):
        return found
    generator = np.random.default_rng(settings.seed)
    for _ in range(_STARTS):
        if len(found) == _MOST_GOALS:
            break
        more = solver.solve(T_root_tool, kinematics.random(generator), most_starts=1)
        positions = _unwound(kinematics, more.positions, start)
        is_new = all(float(np.abs(positions - one).max()) > _DIFFERENT for one in found)
        if more.is_reached and is_new:
            found.append(positions)
    condition = edges.condition
    return [one for one in found if condition is None or condition(one)] or found


def _unwound(kinematics: GroupKinematics, positions: Array, start: Array) -> Array:
    """Return positions with the same pose, each joint within half a turn of the start if it can be.

    Joints of many arms turn more than once, and often links are in the way of the longer turn.
    """
    turn = 2.0 * math.pi
    joints = kinematics.model.description.joints
    leaders = {leader for _, leader, *_ in kinematics.model.joints.followers(set(kinematics.names))}
    unwound = positions.copy()
    for place, name in enumerate(kinematics.names):
        if joints[name].type == "prismatic" or name in leaders:
            continue
        at = float(positions[place])
        lower, upper = float(kinematics.lower[place]), float(kinematics.upper[place])
        turns = round((float(start[place]) - at) / turn)
        while turns and not lower <= at + turns * turn <= upper:
            turns -= int(math.copysign(1, turns))
        unwound[place] = at + turns * turn
    return unwound


def _unreachable(solution: IkSolution) -> PlanningError:
    binding = "; ".join(solution.binding)
    if solution.collisions:
        code = MoveItErrorCode.GOAL_IN_COLLISION
        return PlanningError(f"The goal pose is in collision: {binding}", code)
    away = (
        f"{1000.0 * solution.position_error_m:.0f} mm"
        if solution.position_error_m > 1e-3
        else f"{math.degrees(solution.rotation_error_rad):.1f}°"
    )
    return PlanningError(
        f"The goal pose cannot be reached, the nearest is {away} away: {binding}",
        MoveItErrorCode.NO_IK_SOLUTION,
    )


def _joined(
    kinematics: GroupKinematics,
    legs: Sequence[_Leg],
    settings: MotionSettings,
    *,
    planner: str,
    began: float,
    waypoints: Array,
    notes: tuple[str, ...],
    fraction: float = 1.0,
) -> MotionPlan:
    """Return the plan of motions one after the other."""
    times, positions = [np.zeros(1)], [waypoints[:1]]
    still = np.zeros((1, len(kinematics.names)))
    velocities, accelerations = [still], [still]
    end = 0.0
    for leg in legs:
        points = sampled(leg.law, settings.period_s)
        times.append(end + points.times[1:])
        positions.append(points.positions[1:])
        velocities.append(points.velocities[1:])
        accelerations.append(points.accelerations[1:])
        end = float(times[-1][-1])
    return MotionPlan(
        joint_names=kinematics.names,
        times=np.concatenate(times),
        positions=np.vstack(positions),
        velocities=np.vstack(velocities),
        accelerations=np.vstack(accelerations),
        planner=planner,
        computing_s=time.monotonic() - began,
        duration_before_jerk_s=sum(leg.before_jerk_s for leg in legs),
        waypoints=waypoints,
        fraction=fraction,
        notes=notes,
    )

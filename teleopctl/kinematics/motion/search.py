"""Search of a path between states of a group: checks of both ends, way out, planner."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import daqp
import numpy as np

from teleopctl.kinematics.error_codes import MoveItErrorCode, PlanningError
from teleopctl.kinematics.group_kinematics import GroupKinematics
from teleopctl.kinematics.motion.constraint_planner import ConstraintPlanner, PathConstraint
from teleopctl.kinematics.motion.edges import STEP_RAD, EdgeChecker
from teleopctl.kinematics.motion.planner import Planner, Query, search_bounds
from teleopctl.kinematics.poses import Array

OUTSIDE = 0.05
"""Largest distance of a start outside a joint limit: MoveIt's ``start_state_max_bounds_error``."""
# A goal this far outside of a limit (rad or m) is meant to be at it.
_ROUNDING = 1e-6
# Longest way out of a collision, and its steps, rad or m of the joint that moves most; and the
# distance that bodies move apart in a step, m.
_LONGEST_WAY_OUT, _STEP_OUT, _APART_M = 0.5, 0.01, 0.002
# Pairs of bodies that one message names.
_MOST_NAMED = 3


@dataclass(frozen=True, slots=True)
class FoundPath:
    """Path between two states.

    Attributes:
        corners: Corners of the path, (m, n), from the start to the goal.
        planner: Library and name of the planner; ``straight`` where the straight motion is free.
        first: Number of the corner at which the path is free and within the limits: above 0 if the
            start is not.
        notes: Notes for the caller, one sentence each.
        is_curve: Whether the corners are points of a curve on which a constraint is kept.
    """

    corners: Array
    planner: str
    first: int = 0
    notes: tuple[str, ...] = ()
    is_curve: bool = False


def find_path(
    edges: EdgeChecker,
    planner: Planner,
    start: Array,
    goals: Array,
    *,
    timeout_s: float = 5.0,
    seed: int = 0,
    parameters: Mapping[str, str] | None = None,
) -> FoundPath:
    """Return a free path from a state to one of several.

    A start in collision is left by the shortest way on which the bodies move apart. A condition
    that is a `PathConstraint` is kept by a `ConstraintPlanner`.

    Args:
        edges: Checker of states and motions; its distance is lowered to what the ends allow.
        planner: The planner.
        start: Start, (n,).
        goals: Goals, (g, n).
        timeout_s: Time for all of the search, s.
        seed: Start of the random numbers.
        parameters: Parameters of the planner.

    Raises:
        PlanningError: There is no path, or none was found in time.
    """
    deadline = time.monotonic() + timeout_s
    kinematics = edges.kinematics
    _check_start(kinematics, start)
    goals = _reachable_goals(kinematics, start, goals)
    # Bodies that rest nearer to each other than is kept on the way, at the start or at a goal.
    edges.loosen(start, *goals)
    way_out, notes = _leave(edges, start)
    goals = _free_goals(edges, goals)
    inside = way_out[-1]
    order = np.argsort(np.linalg.norm(goals - inside, axis=1), kind="stable")
    for goal in goals[order]:
        if edges.is_edge_free(inside, goal):
            corners = np.vstack((way_out, goal[None, :]))
            return FoundPath(corners, "straight", len(way_out) - 1, notes)
    lower, upper = search_bounds(edges, np.vstack((inside[None, :], goals)))
    left = max(0.0, deadline - time.monotonic())
    is_curve = isinstance(edges.condition, PathConstraint)
    if is_curve:
        planner, parameters = ConstraintPlanner(), {}
    query = Query(inside, goals[order], lower, upper, left, seed, parameters or {})
    found = planner.search(edges, query)
    if found is None:
        raise PlanningError(
            f"{planner.text} found no path within {timeout_s:g} s",
            MoveItErrorCode.TIMED_OUT,
            hint="Allow more time, or another planner; the goal may be walled in.",
        )
    corners = np.vstack((way_out[:-1], found))
    return FoundPath(corners, planner.text, len(way_out) - 1, notes, is_curve)


def touching_text(edges: EdgeChecker, positions: Array) -> str:
    """Return which bodies touch at a state, as ``'a' and 'b' (-0.004 m)``; empty for none."""
    found = edges.touching(positions)
    names = [f"'{first}' and '{second}' ({m:.3f} m)" for m, (first, second) in found[:_MOST_NAMED]]
    more = len(found) - _MOST_NAMED
    return ", ".join(names) + (f" and {more} pairs more" if more > 0 else "")


def check_positions(kinematics: GroupKinematics, positions: Array, what: str) -> Array:
    """Return positions as an array, (n,).

    Args:
        kinematics: Kinematics of the group.
        positions: The positions.
        what: What they are, for the message: ``start`` or ``goal``.

    Raises:
        PlanningError: There are more or fewer than the group has joints, or one is no number.
    """
    array = np.asarray(positions, np.float64)
    names = kinematics.names
    code = (
        MoveItErrorCode.INVALID_ROBOT_STATE
        if what == "start"
        else MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
    )
    if array.shape != (len(names),):
        raise PlanningError(
            f"The {what} has {array.size} positions, the group '{kinematics.group.name}' "
            f"{len(names)} joints: {', '.join(names)}",
            code,
        )
    for name, value in zip(names, array.tolist(), strict=True):
        if not math.isfinite(value):
            raise PlanningError(f"The {what} of joint '{name}' is {value}, no finite number", code)
    return array


def _check_start(kinematics: GroupKinematics, start: Array) -> None:
    for name, at, lower, upper in zip(
        kinematics.names, start, kinematics.lower, kinematics.upper, strict=True
    ):
        if not lower - OUTSIDE <= at <= upper + OUTSIDE:
            raise PlanningError(
                f"Joint '{name}' starts at {at:.4g}, outside its limits [{lower:.4g}, {upper:.4g}]",
                MoveItErrorCode.START_STATE_INVALID,
                hint="Move it back by hand, or correct the limits.",
            )


def _reachable_goals(kinematics: GroupKinematics, start: Array, goals: Array) -> Array:
    """Return the goals within the limits.

    A continuous joint has two: by the shorter way round, and, since something may be in that way,
    by the other one.
    """
    turn = 2.0 * math.pi
    is_continuous = np.array([limit.angle_wraparound for limit in kinematics.limits])
    goals = goals + turn * np.round((start - goals) / turn) * is_continuous
    others = []
    for place in np.flatnonzero(is_continuous).tolist():
        other = goals.copy()
        other[:, place] -= np.where(goals[:, place] > start[place], turn, -turn)
        others.append(other)
    goals = np.vstack((goals, *others))
    outside = (goals < kinematics.lower - _ROUNDING) | (goals > kinematics.upper + _ROUNDING)
    kept = ~outside.any(axis=1)
    if kept.any():
        return np.clip(goals[kept], kinematics.lower, kinematics.upper)
    place = int(np.flatnonzero(outside[0])[0])
    lower, upper = float(kinematics.lower[place]), float(kinematics.upper[place])
    raise PlanningError(
        f"The goal of joint '{kinematics.names[place]}' is {goals[0, place]:.4g}, outside its "
        f"limits [{lower:.4g}, {upper:.4g}]",
        MoveItErrorCode.GOAL_STATE_INVALID,
    )


def _free_goals(edges: EdgeChecker, goals: Array) -> Array:
    kept = [goal for goal in goals if edges.is_free(goal)]
    if kept:
        return np.array(kept)
    if text := touching_text(edges, goals[0]):
        which = "The goal is" if len(goals) == 1 else f"All {len(goals)} goals are"
        raise PlanningError(f"{which} in collision: {text}", MoveItErrorCode.GOAL_IN_COLLISION)
    raise PlanningError(
        "The goal does not meet the constraints of the path",
        MoveItErrorCode.GOAL_VIOLATES_PATH_CONSTRAINTS,
    )


def _leave(edges: EdgeChecker, start: Array) -> tuple[Array, tuple[str, ...]]:
    """Return the way, (w, n), from the start to a state that is free and within the limits."""
    inside = edges.kinematics.clamp(start)
    states, notes = [start], []
    if not np.array_equal(inside, start):
        outside = np.flatnonzero(inside != start).tolist()
        names = ", ".join(f"'{edges.kinematics.names[place]}'" for place in outside)
        notes.append(f"The start is outside the limits of {names}: the motion begins by going back")
        states.append(inside)
    if edges.is_free(inside):
        return np.array(states), tuple(notes)
    text = touching_text(edges, inside)
    if not text:
        raise PlanningError(
            "The start does not meet the constraints of the path",
            MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS,
        )
    way = _way_out(edges, inside)
    if way is None:
        raise PlanningError(
            f"The start is in collision: {text}",
            MoveItErrorCode.START_STATE_IN_COLLISION,
            hint=f"There is no way out within {_LONGEST_WAY_OUT:g} rad or m: move the robot by "
            "hand, or allow the pair to touch.",
        )
    notes.append(f"The start is in collision ({text}): the motion begins by moving them apart")
    return np.vstack((*states, way)), tuple(notes)


def _way_out(edges: EdgeChecker, start: Array) -> list[Array] | None:
    """Return states on a short way out of a collision, without the start; None if there is none.

    Each step is the smallest one that moves all touching bodies apart by some distance, if there is
    one, and moves no others together:

        min |dq|²  with  n_k (J_b - J_a) dq >= step for touching, >= -d_k for near bodies.
    """
    kinematics = edges.kinematics
    count = len(kinematics.names)
    at, way = start, list[Array]()
    kinematics.set(at)
    near = edges.near(0.02)
    deepest = near[0].distance_m if near else 0.0
    for _ in range(int(_LONGEST_WAY_OUT / STEP_RAD)):
        rows = np.array([one.separation(kinematics) for one in near])
        least = np.array(
            [
                _APART_M if one.distance_m <= edges.least_m else edges.least_m - one.distance_m
                for one in near
            ]
        )
        step, _, flag, _ = daqp.solve(
            np.eye(count),
            np.zeros(count),
            rows,
            np.concatenate((kinematics.upper - at, np.full(len(near), 1e30))),
            np.concatenate((kinematics.lower - at, least)),
            np.zeros(count + len(near), dtype=np.int32),
        )
        size = float(np.abs(step).max(initial=0.0)) if flag > 0 else 0.0
        if size <= 1e-9:
            return None
        at = kinematics.clamp(at + step * min(1.0, _STEP_OUT / size))
        if float(np.abs(at - start).max()) > _LONGEST_WAY_OUT:
            return None
        kinematics.set(at)
        near = edges.near(0.02)
        now = near[0].distance_m if near else math.inf
        if now < deepest - 1e-4:
            return None
        deepest = max(deepest, min(now, edges.least_m))
        way.append(at)
        if edges.is_free(at):
            # The states between are nearly always on one line.
            return _thinned(start, way)
    return None


def _thinned(start: Array, way: Sequence[Array]) -> list[Array]:
    """Return the last state of a way alone if the others are near the line to it, else all."""
    whole = way[-1] - start
    square = float(whole @ whole)
    for state in way:
        offset = state - start
        across = offset - whole * (float(offset @ whole) / square)
        if float(np.abs(across).max()) > 0.5 * STEP_RAD:
            return list(way)
    return [way[-1]]

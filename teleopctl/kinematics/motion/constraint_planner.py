"""Planner of paths on which a constraint is kept, such as a cup that stays upright.

States that meet a narrow constraint are hardly ever found by sampling. So each step of the search
is moved onto the constraint: by Newton steps on the residual e(q), dq = -J^+ e with J = de/dq.
Source: CBiRRT2, Berenson, Srinivasa and Kuffner 2011.
"""

from __future__ import annotations

import time
from typing import Protocol, runtime_checkable

import numpy as np

from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.motion.planner import OWN, Planner, Query
from teleopctl.kinematics.motion.shortcut import path_length
from teleopctl.kinematics.poses import Array

# Longest step between two states, rad or m, and how much longer it may be after the projection.
_STEP, _STRETCH = 0.1, 2.0
# Newton steps at most, the residual at which they end, and the difference for the derivatives.
_NEWTON, _RESIDUAL, _DIFFERENCE = 12, 1e-6, 1e-6
# Part of a step below which a state is left out.
_CLOSE = 0.25
# Attempts at shortening a path, those in a row that may fail, and the part of the time for them.
_MOST_SHORTCUTS, _PATIENCE, _SHORTEN = 120, 20, 0.2


@runtime_checkable
class PathConstraint(Protocol):
    """Condition on positions of the independent joints, (n,), with its residual."""

    def __call__(self, positions: Array) -> bool:
        """Return whether positions meet the constraint."""
        ...

    def residual(self, positions: Array) -> Array:
        """Return the signed violation of each of the constraint's m parts, (m,); 0 within."""
        ...


class ConstraintPlanner(Planner):
    """Bidirectional search with each state moved onto the `PathConstraint` of the edge checker."""

    library = OWN
    name = "CBiRRT"
    parameters = ()

    def search(self, edges: EdgeChecker, query: Query) -> Array | None:
        """Return the corners of a path, (m, n), or None if none was found in time."""
        deadline = time.monotonic() + query.timeout_s
        generator = np.random.default_rng(query.seed)
        steps = _Steps(edges, query)
        trees = (_Tree(query.start[None, :]), _Tree(query.goals))
        while time.monotonic() < deadline:
            for tree, other in (trees, trees[::-1]):
                target = generator.uniform(query.lower, query.upper)
                number = tree.grow(steps, tree.nearest(target), target)
                meeting = other.grow(steps, other.nearest(tree.states[number]), tree.states[number])
                if np.abs(other.states[meeting] - tree.states[number]).max() < 1e-9:
                    first, second = tree.path(number), other.path(meeting)
                    if tree is trees[1]:
                        first, second = second, first
                    path = np.vstack((first, second[::-1][1:]))
                    now = time.monotonic()
                    until = min(deadline, now + _SHORTEN * query.timeout_s)
                    return _shortened(steps, path, generator, until)
        return None


class _Steps:
    """Steps of the search: short ones, moved onto the constraint, and free."""

    def __init__(self, edges: EdgeChecker, query: Query) -> None:
        assert isinstance(edges.condition, PathConstraint)
        self._edges, self._constraint = edges, edges.condition
        self._lower, self._upper = query.lower, query.upper

    def towards(self, start: Array, target: Array) -> Array | None:
        """Return the next state on the way to a target; None if the way ends at the start."""
        change = target - start
        distance = float(np.abs(change).max())
        if distance <= _STEP:
            found: Array | None = target
            if not self._constraint(target):
                found = self._projected(target)
        else:
            found = self._projected(start + change * (_STEP / distance))
        if found is None:
            return None
        moved = float(np.abs(found - start).max())
        is_nearer = float(np.linalg.norm(target - found)) < float(np.linalg.norm(change)) - 1e-6
        if not (1e-9 < moved <= _STRETCH * _STEP and is_nearer):
            return None
        edges = self._edges
        return found if edges.is_free(found) and edges.is_edge_free(start, found) else None

    def way(self, start: Array, target: Array) -> list[Array] | None:
        """Return the states on the way to a target, with both; None if it is not reached."""
        states = [start]
        while np.abs(states[-1] - target).max() > 1e-9:
            found = self.towards(states[-1], target)
            if found is None:
                return None
            states.append(found)
        return states

    def _projected(self, positions: Array) -> Array | None:
        """Return the positions near others that meet the constraint, (n,); None without any."""
        at = positions
        for _ in range(_NEWTON):
            residual = self._constraint.residual(at)
            if float(np.abs(residual).max(initial=0.0)) <= _RESIDUAL:
                return at if self._constraint(at) else None
            columns = []
            for place in range(len(at)):
                other = at.copy()
                other[place] += _DIFFERENCE
                columns.append((self._constraint.residual(other) - residual) / _DIFFERENCE)
            step = np.linalg.lstsq(np.stack(columns, axis=1), residual, rcond=1e-4)[0]
            at = np.clip(at - step, self._lower, self._upper)
            if float(np.abs(at - positions).max()) > _STRETCH * _STEP:
                return None
        return None


class _Tree:
    """States that are reached from roots, (r, n)."""

    def __init__(self, roots: Array) -> None:
        self.states = list(roots)
        self._parents = [-1] * len(roots)
        self._array = np.array(roots)

    def nearest(self, target: Array) -> int:
        """Return the number of the state nearest to a target."""
        known = len(self._array)
        if known < len(self.states):
            self._array = np.vstack((self._array, self.states[known:]))
        change = self._array - target
        return int(np.einsum("ij,ij->i", change, change).argmin())

    def grow(self, steps: _Steps, number: int, target: Array) -> int:
        """Add the states on the way from one to a target; return the number of the last one."""
        while (found := steps.towards(self.states[number], target)) is not None:
            self.states.append(found)
            self._parents.append(number)
            number = len(self.states) - 1
            if np.abs(found - target).max() < 1e-9:
                break
        return number

    def path(self, number: int) -> Array:
        """Return the states from a root to a state, (m, n)."""
        states = []
        while number >= 0:
            states.append(self.states[number])
            number = self._parents[number]
        return np.array(states[::-1])


def _shortened(
    steps: _Steps, path: Array, generator: np.random.Generator, deadline: float
) -> Array:
    """Return a path, (k, n), in which detours between its states are left out."""
    misses = 0
    for _ in range(_MOST_SHORTCUTS):
        if len(path) < 3 or misses >= _PATIENCE or time.monotonic() >= deadline:
            break
        first, last = np.sort(generator.choice(len(path), 2, replace=False)).tolist()
        misses += 1
        if last - first < 2:
            continue
        way = steps.way(path[first], path[last])
        if way is not None and path_length(np.array(way)) < 0.99 * path_length(
            path[first : last + 1]
        ):
            path = np.vstack((path[:first], way, path[last + 1 :]))
            misses = 0
    return _even(path)


def _even(path: Array) -> Array:
    """Return a path without states so near to each other that a spline would overshoot."""
    kept = [path[0]]
    for state in path[1:-1]:
        if min(float(np.abs(state - end).max()) for end in (kept[-1], path[-1])) > _CLOSE * _STEP:
            kept.append(state)
    kept.append(path[-1])
    return np.array(kept)

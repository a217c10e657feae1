"""Search of a path by trees from both ends, where OMPL is missing."""

from __future__ import annotations

import math
import time
from collections import deque

import numpy as np

from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.motion.planner import (
    DEFAULT_PLANNER,
    OWN,
    RANGE,
    Planner,
    Query,
    number_of,
)
from teleopctl.kinematics.poses import Array


class TreePlanner(Planner):
    """Rapidly exploring trees from the start and from all goals.

    In turn, those from one end are extended towards a random state, and those from the other end
    connected to the new state if they can be. Further trees from random free states, and edges up
    to an obstacle, made searches in narrow passages slower.
    Source: Kuffner and LaValle 2000 (RRT-Connect).
    """

    name = DEFAULT_PLANNER
    library = OWN
    parameters = ("range",)

    def search(self, edges: EdgeChecker, query: Query) -> Array | None:
        """Return the corners of a path, (m, n), or None if none was found in time."""
        longest = RANGE * float(np.linalg.norm(query.upper - query.lower))
        for key, value in query.parameters.items():
            self.check_parameter(key)
            longest = number_of(self.text, key, value) or longest
        deadline = time.monotonic() + query.timeout_s
        generator = np.random.default_rng(query.seed)
        forest = _Forest(edges, longest, query.start, query.goals)
        while time.monotonic() < deadline:
            for tree in (0, 1):
                target = generator.uniform(query.lower, query.upper)
                new = forest.extend(tree, target)
                if new is not None and forest.connect(1 - tree, new):
                    return forest.path()
        return None


class _Forest:
    """States in trees from the start, and in trees from each goal."""

    def __init__(self, edges: EdgeChecker, longest: float, start: Array, goals: Array) -> None:
        self._edges, self._longest = edges, longest
        roots = np.vstack((start[None, :], goals))
        self._states = np.zeros((256, len(start)))
        self._states[: len(roots)] = roots
        self._trees = np.ones(256, dtype=np.int8)
        self._trees[0] = 0
        self._count = len(roots)
        self._parents = [-1] * len(roots)
        self._bridge = (-1, -1)

    def extend(self, tree: int, target: Array) -> int | None:
        """Add a state to a tree, from its nearest one towards a target; return its number."""
        near = self._nearest(tree, target)
        origin = self._states[near]
        change = target - origin
        distance = math.sqrt(float(change @ change))
        if distance <= 1e-12:
            return None
        if distance > self._longest:
            target = origin + change * (self._longest / distance)
        if not (self._edges.is_free(target) and self._edges.is_edge_free(origin, target)):
            return None
        return self._add(tree, target, near)

    def connect(self, tree: int, number: int) -> bool:
        """Extend a tree towards a state of the other one until it is reached or nothing is free."""
        target = self._states[number]
        near = self._nearest(tree, target)
        while True:
            change = target - self._states[near]
            distance = math.sqrt(float(change @ change))
            if distance <= self._longest:
                if not self._edges.is_edge_free(self._states[near], target):
                    return False
                self._bridge = (near, number) if tree == 0 else (number, near)
                return True
            step = self._states[near] + change * (self._longest / distance)
            free = self._edges.is_free(step)
            if not (free and self._edges.is_edge_free(self._states[near], step)):
                return False
            near = self._add(tree, step, near)

    def path(self) -> Array:
        """Return the path through the states at which the trees have met, (m, n)."""
        path: deque[Array] = deque()
        at, other = self._bridge
        while at >= 0:
            path.appendleft(self._states[at])
            at = self._parents[at]
        while other >= 0:
            path.append(self._states[other])
            other = self._parents[other]
        return np.array(path)

    def _nearest(self, tree: int, state: Array) -> int:
        change = self._states[: self._count] - state
        squares = np.einsum("ij,ij->i", change, change)
        squares[self._trees[: self._count] != tree] = math.inf
        return int(squares.argmin())

    def _add(self, tree: int, state: Array, parent: int) -> int:
        if self._count == len(self._states):
            self._states = np.vstack((self._states, np.zeros_like(self._states)))
            self._trees = np.concatenate((self._trees, np.ones_like(self._trees)))
        number = self._count
        self._states[number], self._trees[number] = state, tree
        self._parents.append(parent)
        self._count += 1
        return number

"""Shortening of a path: random shortcuts that are free."""

from __future__ import annotations

import time

import numpy as np

from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.poses import Array

# Shortcuts that are tried in a row without shortening the path, and in all; and the part by which
# one must shorten it.
_PATIENCE, _MOST, _LEAST_GAIN = 20, 200, 0.01


def shorten(edges: EdgeChecker, corners: Array, *, seed: int = 0, timeout_s: float = 1.0) -> Array:
    """Return a shorter path with the same ends.

    Corners that a free straight motion passes by are left out; then two random points of the path
    are joined by a straight motion where that is free and shorter.
    Source: Geraerts and Overmars 2007.

    Args:
        edges: Checker of motions.
        corners: Corners of the path, (m, n), of which each motion is free.
        seed: Start of the random numbers; the result is the same each time unless the time is over.
        timeout_s: Time for it, s.

    Returns:
        Corners of the shorter path, (k, n).
    """
    deadline = time.monotonic() + timeout_s
    path = _without_detours(edges, corners, deadline)
    generator = np.random.default_rng(seed)
    misses = 0
    for _ in range(_MOST):
        if len(path) < 3 or misses >= _PATIENCE or time.monotonic() >= deadline:
            break
        shorter = _shortcut(edges, path, generator)
        misses = misses + 1 if shorter is None else 0
        path = path if shorter is None else shorter
    return _without_detours(edges, path, deadline)


def path_length(corners: Array) -> float:
    """Return the length of a path in the space of the joints."""
    return float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())


def _shortcut(edges: EdgeChecker, path: Array, generator: np.random.Generator) -> Array | None:
    """Return a path with one more shortcut, or None if the tried one is not free or not shorter."""
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    sums = np.concatenate(([0.0], np.cumsum(lengths)))
    first, second = np.sort(generator.uniform(0.0, sums[-1], 2)).tolist()
    before = min(int(np.searchsorted(sums, first, side="right")) - 1, len(path) - 2)
    after = min(int(np.searchsorted(sums, second, side="right")) - 1, len(path) - 2)
    if before == after:
        return None
    start = _between(path, lengths, sums, before, first)
    end = _between(path, lengths, sums, after, second)
    gain = (second - first) - float(np.linalg.norm(end - start))
    if gain < _LEAST_GAIN * float(sums[-1]) or not edges.is_edge_free(start, end):
        return None
    shorter = np.vstack((path[: before + 1], start, end, path[after + 1 :]))
    return _distinct(shorter)


def _between(path: Array, lengths: Array, sums: Array, place: int, at: float) -> Array:
    part = (at - float(sums[place])) / max(float(lengths[place]), 1e-12)
    return np.asarray(path[place] + part * (path[place + 1] - path[place]))


def _distinct(path: Array) -> Array:
    """Return a path without corners that are equal to the one before."""
    kept = np.concatenate(([True], np.abs(np.diff(path, axis=0)).max(axis=1) > 1e-9))
    kept[-1] = True
    return np.asarray(path[kept])


def _without_detours(edges: EdgeChecker, path: Array, deadline: float) -> Array:
    """Return a path without the corners that a free straight motion can skip."""
    corners = list(_distinct(path))
    place = 0
    while place < len(corners) - 2 and time.monotonic() < deadline:
        # The farthest corner first.
        for other in range(len(corners) - 1, place + 1, -1):
            if edges.is_edge_free(corners[place], corners[other]):
                del corners[place + 1 : other]
                break
        place += 1
    return np.array(corners)

"""Geometry of a joint path: piecewise polynomials of a path parameter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from teleopctl.kinematics.poses import Array

# Corners nearer to each other than this (rad or m) are one.
_SAME = 1e-9


@dataclass(frozen=True, slots=True)
class JointPath:
    """Path in the space of n joints, in K pieces that are polynomials of degree 3 at most.

    In the piece k, from ``breaks[k]`` to ``breaks[k + 1]``, the positions are sum_i c_i u^i with
    u = s - ``breaks[k]``.

    Attributes:
        breaks: Values of the path parameter s between the pieces, (K + 1,), rising from 0.
        coefficients: Coefficients c_0 to c_3 of each piece, (K, 4, n).
        stops: Numbers of the breaks at which the direction jumps, so that the motion has to stop.
    """

    breaks: Array
    coefficients: Array
    stops: tuple[int, ...] = ()

    @property
    def length(self) -> float:
        """Largest value of the path parameter."""
        return float(self.breaks[-1])

    @classmethod
    def rounded(cls, corners: Array, scale: Array, tolerance: float | Array) -> JointPath:
        """Return the polyline through corners, with its corners rounded by parabolas.

        A parabola begins and ends at the same distance b from its corner, in the directions p and
        r of the two lines, and passes it at b |r - p| / 4. The direction is continuous.

        Args:
            corners: Corners, (m, n), of which the first and last are ends; m at least 2.
            scale: Unit of each joint, (n,), in which the path parameter is a length.
            tolerance: Largest distance of any joint from the polyline, rad or m; one for all
                corners, or for each of the (m - 2,) between the ends. At a corner with 0 the motion
                stops.
        """
        if np.ndim(tolerance) == 0:
            corners = distinct(corners)
        if len(corners) < 2:
            return cls(np.array([0.0, 1.0]), _constant(corners[0]))
        lines = np.diff(corners, axis=0)
        lengths = np.linalg.norm(lines / scale, axis=1)
        directions = lines / lengths[:, None]
        turns = np.diff(directions, axis=0)
        with np.errstate(divide="ignore"):
            wanted = 4.0 * tolerance / np.abs(turns).max(axis=1, initial=0.0)
        is_straight = np.abs(turns / scale).max(axis=1, initial=0.0) < 1e-9
        room = 0.5 * np.minimum(lengths[:-1], lengths[1:])
        halves = np.where(is_straight, 0.0, np.minimum(wanted, room))
        # From the end of one parabola to the begin of the next.
        before = np.concatenate(([0.0], halves))
        straight = lengths - before - np.concatenate((halves, [0.0]))
        breaks, pieces, stops = [0.0], [], []
        for place, direction in enumerate(directions):
            start = corners[place] + before[place] * direction
            if straight[place] > 1e-9 * lengths[place]:
                pieces.append(np.array([start, direction, 0.0 * start, 0.0 * start]))
                breaks.append(breaks[-1] + float(straight[place]))
            if place == len(halves) or is_straight[place]:
                continue
            half = float(halves[place])
            if half <= 0.0:
                stops.append(len(pieces))
                continue
            start = corners[place + 1] - half * direction
            bend = turns[place] / (4.0 * half)
            pieces.append(np.array([start, direction, bend, 0.0 * start]))
            breaks.append(breaks[-1] + 2.0 * half)
        return cls(np.array(breaks), np.array(pieces), tuple(stops))

    @classmethod
    def spline(cls, points: Array, scale: Array) -> JointPath:
        """Return the natural cubic spline through points, (m, n): its second derivative is smooth.

        Args:
            points: Points of the path, m at least 2.
            scale: Unit of each joint, (n,), in which the distances between points are measured.
        """
        points = distinct(points)
        if len(points) < 2:
            return cls(np.array([0.0, 1.0]), _constant(points[0]))
        steps = np.linalg.norm(np.diff(points, axis=0) / scale, axis=1)
        return cls.through(points, np.concatenate(([0.0], np.cumsum(steps))))

    @classmethod
    def through(cls, points: Array, parameters: Array) -> JointPath:
        """Return the natural cubic spline through points, (m, n), at path parameters, (m,)."""
        steps = np.diff(parameters)
        slopes = np.diff(points, axis=0) / steps[:, None]
        second = np.zeros_like(points)
        if len(points) > 2:
            second[1:-1] = _tridiagonal(
                steps[1:-1], 2.0 * (steps[:-1] + steps[1:]), 6.0 * np.diff(slopes, axis=0)
            )
        width = steps[:, None]
        coefficients = np.stack(
            (
                points[:-1],
                slopes - width * (2.0 * second[:-1] + second[1:]) / 6.0,
                0.5 * second[:-1],
                (second[1:] - second[:-1]) / (6.0 * width),
            ),
            axis=1,
        )
        return cls(parameters - parameters[0], coefficients)

    def pieces(self, parameters: Array) -> npt.NDArray[np.intp]:
        """Return the number of the piece of each path parameter, (k,)."""
        found = np.searchsorted(self.breaks, parameters, side="right") - 1
        return np.clip(found, 0, len(self.coefficients) - 1)

    def positions(self, parameters: Array, pieces: npt.NDArray[np.intp] | None = None) -> Array:
        """Return the positions at path parameters, (k, n)."""
        pieces = self.pieces(parameters) if pieces is None else pieces
        u = (parameters - self.breaks[pieces])[:, None]
        c = self.coefficients[pieces]
        return np.asarray(c[:, 0] + u * (c[:, 1] + u * (c[:, 2] + u * c[:, 3])))

    def derivatives(
        self, parameters: Array, pieces: npt.NDArray[np.intp] | None = None
    ) -> tuple[Array, Array]:
        """Return first and second derivatives by the path parameter, (k, n) each.

        Args:
            parameters: Path parameters, (k,).
            pieces: The piece of each, where it is not the one that begins there.
        """
        pieces = self.pieces(parameters) if pieces is None else pieces
        u = (parameters - self.breaks[pieces])[:, None]
        c = self.coefficients[pieces]
        first = c[:, 1] + u * (2.0 * c[:, 2] + u * (3.0 * c[:, 3]))
        return np.asarray(first), np.asarray(2.0 * c[:, 2] + 6.0 * u * c[:, 3])


def distinct(points: Array) -> Array:
    """Return points of a path, (m, n), without those that are equal to the one before."""
    changes = np.abs(np.diff(points, axis=0)).max(axis=1, initial=0.0)
    return np.asarray(points[np.concatenate(([True], changes > _SAME))])


def _constant(point: Array) -> Array:
    coefficients = np.zeros((1, 4, len(point)))
    coefficients[0, 0] = point
    return coefficients


def _tridiagonal(beside: Array, diagonal: Array, right: Array) -> Array:
    """Return the solution, (k, n), of a symmetric tridiagonal system (Thomas' algorithm)."""
    count = len(diagonal)
    ratios, solution = np.zeros(count), np.array(right)
    pivot = float(diagonal[0])
    solution[0] /= pivot
    for row in range(1, count):
        ratios[row] = float(beside[row - 1]) / pivot
        pivot = float(diagonal[row]) - float(beside[row - 1]) * float(ratios[row])
        solution[row] = (right[row] - float(beside[row - 1]) * solution[row - 1]) / pivot
    for row in range(count - 2, -1, -1):
        solution[row] -= ratios[row + 1] * solution[row + 1]
    return solution

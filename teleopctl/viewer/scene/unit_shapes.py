"""Triangles of the shapes that are drawn many at a time, each of size 1 around the origin.

A shape that stands many times in the picture is sent once, with a pose, a scale and a colour for
each. Where it stands a few times, its roundness is finer.
"""

from __future__ import annotations

import functools
from itertools import pairwise

import numpy as np
import numpy.typing as npt

Triangles = tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]
"""Corners, shape (n, 3), and indices of them, shape (m, 3), counter-clockwise from outside."""

# Corners around, and rings of them from pole to pole.
_COARSE = (20, 9)
_FINE = (48, 23)


@functools.cache
def unit_shape(name: str, *, fine: bool = False) -> Triangles:
    """Return the triangles of a shape of unit size.

    Args:
        name: ``box``; ``sphere`` of diameter 1; ``cylinder`` of diameter 1 and height 1 along z;
            ``cone`` of diameter 1 and height 1, its tip towards z.
        fine: Whether it looks round from near, for five times the triangles.

    Raises:
        KeyError: There is no such shape.
    """
    corners, faces = _MAKERS[name](*(_FINE if fine else _COARSE))
    return np.array(corners, np.float32), np.array(faces, np.uint32)


Corners = list[tuple[float, float, float]]
Faces = list[tuple[int, int, int]]


def _box(_around: int, _rings: int) -> tuple[Corners, Faces]:
    # four corners for each side, so that edges are sharp
    corners: Corners = []
    faces: Faces = []
    for axis in range(3):
        for sign in (-0.5, 0.5):
            first = len(corners)
            for u, v in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
                corner = [0.0, 0.0, 0.0]
                corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = sign, u, v
                corners.append((corner[0], corner[1], corner[2]))
            a, b, c, d = range(first, first + 4)
            faces += [(a, b, c), (a, c, d)] if sign > 0 else [(a, c, b), (a, d, c)]
    return corners, faces


def _ring(n: int, z: float, radius: float = 0.5) -> Corners:
    angles = 2 * np.pi * np.arange(n) / n
    return [(radius * float(np.cos(a)), radius * float(np.sin(a)), z) for a in angles]


def _band(n: int, lower: int, upper: int) -> Faces:
    """The triangles between two rings, given by their first corners."""
    faces: Faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(lower + i, lower + j, upper + j), (lower + i, upper + j, upper + i)]
    return faces


def _disc(n: int, ring: int, centre: int, *, up: bool) -> Faces:
    pairs = [(ring + i, ring + (i + 1) % n) for i in range(n)]
    return [(a, b, centre) if up else (b, a, centre) for a, b in pairs]


def _cylinder(n: int, _rings: int) -> tuple[Corners, Faces]:
    bottom, top = _ring(n, -0.5), _ring(n, 0.5)
    # The discs have corners of their own, so that their edges are sharp.
    corners = [*bottom, *top, *bottom, *top, (0.0, 0.0, -0.5), (0.0, 0.0, 0.5)]
    return corners, [
        *_band(n, 0, n),
        *_disc(n, 2 * n, 4 * n, up=False),
        *_disc(n, 3 * n, 4 * n + 1, up=True),
    ]


def _cone(n: int, _rings: int) -> tuple[Corners, Faces]:
    base = _ring(n, -0.5)
    # A tip for each side, or its shading would point nowhere.
    tips = [(0.0, 0.0, 0.5)] * n
    sides = [(i, (i + 1) % n, n + i) for i in range(n)]
    corners = [*base, *tips, *base, (0.0, 0.0, -0.5)]
    return corners, [*sides, *_disc(n, 2 * n, 3 * n, up=False)]


def _sphere(n: int, rings: int) -> tuple[Corners, Faces]:
    heights = [np.pi * (ring / (rings + 1) - 0.5) for ring in range(1, rings + 1)]
    corners: Corners = []
    for height in heights:
        corners += _ring(n, 0.5 * float(np.sin(height)), 0.5 * float(np.cos(height)))
    faces: Faces = []
    firsts = range(0, len(corners), n)
    for lower, upper in pairwise(firsts):
        faces += _band(n, lower, upper)
    south, north = len(corners), len(corners) + 1
    faces += _disc(n, 0, south, up=False) + _disc(n, firsts[-1], north, up=True)
    return [*corners, (0.0, 0.0, -0.5), (0.0, 0.0, 0.5)], faces


def is_unit_shape(name: str) -> bool:
    """Return whether `unit_shape` has a shape of this name."""
    return name in _MAKERS


_MAKERS = {"box": _box, "sphere": _sphere, "cylinder": _cylinder, "cone": _cone}

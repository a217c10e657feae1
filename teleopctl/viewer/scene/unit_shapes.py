"""Triangles of box, sphere, cylinder and cone of unit size, plain or with texture coordinates.

A shape drawn many times is sent once, with pose, scale and colour of each instance; a shape drawn
few times has more triangles. trimesh has the same shapes, but with rounded edges, and its import
takes longer than the first picture, which needs no mesh.
"""

from __future__ import annotations

import functools
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from teleopctl.viewer.scene.drawing import Floats

Triangles = tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]
"""Corners, shape (n, 3), and indices of them, shape (m, 3), counter-clockwise from outside."""

# Number of corners of a ring, and of rings from pole to pole.
_COARSE = (20, 9)
_FINE = (48, 23)


@functools.cache
def unit_shape(name: str, *, fine: bool = False) -> Triangles:
    """Return corners and triangles of a box, sphere, cylinder or cone of size 1 around the origin.

    Args:
        name: ``box``; ``sphere`` of diameter 1; ``cylinder`` of diameter 1 and height 1 along z;
            ``cone`` of diameter 1 and height 1, its tip towards z.
        fine: Whether to use five times the triangles.

    Raises:
        KeyError: No shape has this name.
    """
    corners, faces = _MAKERS[name](*(_FINE if fine else _COARSE))
    return np.array(corners, np.float32), np.array(faces, np.uint32)


Corners = list[tuple[float, float, float]]
Faces = list[tuple[int, int, int]]


def _box(_around: int, _rings: int) -> tuple[Corners, Faces]:
    # four separate corners for each side, so that edges are sharp
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
    """Return the triangles between two rings of n corners, given by their first indices."""
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
    # The discs have separate corners, so that their edges are sharp.
    corners = [*bottom, *top, *bottom, *top, (0.0, 0.0, -0.5), (0.0, 0.0, 0.5)]
    return corners, [
        *_band(n, 0, n),
        *_disc(n, 2 * n, 4 * n, up=False),
        *_disc(n, 3 * n, 4 * n + 1, up=True),
    ]


def _cone(n: int, _rings: int) -> tuple[Corners, Faces]:
    base = _ring(n, -0.5)
    # A separate tip for each side: the normal of a shared tip would be undefined.
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
    """Return whether `unit_shape` has a shape of that name."""
    return name in _MAKERS


_MAKERS = {"box": _box, "sphere": _sphere, "cylinder": _cylinder, "cone": _cone}


_AROUND, _FROM_POLE_TO_POLE = 48, 25


class TexturedShape(NamedTuple):
    """Triangles of a shape, with normals and texture coordinates.

    Attributes:
        corners: Corners, three per triangle, counter-clockwise from outside, (3 n, 3).
        normals: Normals of the corners, (3 n, 3).
        uv: Texture coordinates from the upper left, (3 n, 2).
    """

    corners: Floats
    normals: Floats
    uv: Floats


@functools.cache
def textured_shape(name: str) -> TexturedShape:
    """Return a box, cylinder or sphere of size 1, with texture coordinates as in Gazebo.

    Each side of a box and each end of a cylinder shows the whole texture, upright. The texture is
    wrapped once around a cylinder or sphere, with its middle towards x. RViz projects a texture
    from the middle of the shape, so that most sides of a box show one stretched line of pixels.

    Args:
        name: ``box``; ``cylinder`` of diameter 1 and height 1 along z; ``sphere`` of diameter 1.

    Raises:
        KeyError: No shape has this name.
    """
    sheets = _MAPPED_MAKERS[name]()
    return TexturedShape(*(np.concatenate(parts) for parts in zip(*sheets, strict=True)))


def _sheet(corners: Floats, normals: Floats, uv: Floats) -> TexturedShape:
    """Return the triangles of a grid of corners, whose rows go right and down from outside."""

    def between(grid: Floats) -> Floats:
        above, below = grid[:-1], grid[1:]
        left, right = slice(None, -1), slice(1, None)
        cells = [
            *(below[:, left], below[:, right], above[:, right]),
            *(below[:, left], above[:, right], above[:, left]),
        ]
        return np.stack(cells, axis=2).reshape(-1, grid.shape[-1])

    return TexturedShape(between(corners), between(normals), between(uv))


def _mapped_box() -> list[TexturedShape]:
    sheets = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            outwards, up = np.zeros(3), np.zeros(3)
            outwards[axis] = sign
            up[2 if axis < 2 else 1] = 1.0
            right = np.cross(up, outwards)
            uv = np.array([[[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 1.0]]])
            across, down = uv[..., :1] - 0.5, uv[..., 1:] - 0.5
            corners = outwards / 2 + across * right - down * up
            sheets.append(_sheet(corners, np.broadcast_to(outwards, corners.shape), uv))
    return sheets


def _round() -> tuple[Floats, Floats]:
    """Return points of a unit circle from -x over -y, (n, 2), and their fraction of the turn."""
    part = np.linspace(0.0, 1.0, _AROUND + 1)
    angle = 2.0 * np.pi * part - np.pi
    return np.stack([np.cos(angle), np.sin(angle)], -1), part


def _mapped_cylinder() -> list[TexturedShape]:
    circle, part = _round()
    flat = np.zeros((len(circle), 1))
    outwards = np.hstack([circle, flat])
    side = np.stack([outwards / 2 + (0, 0, 0.5), outwards / 2 - (0, 0, 0.5)])
    uv = np.stack([np.stack([part, np.full_like(part, v)], -1) for v in (0.0, 1.0)])
    sheets = [_sheet(side, np.stack([outwards, outwards]), uv)]
    for sign in (1.0, -1.0):
        # Seen from outside, the lower end has the opposite winding.
        rim = circle[:: int(sign)] / 2
        corners = np.stack([np.hstack([ring, flat + sign / 2]) for ring in (0 * rim, rim)])
        uv = np.stack([0.5 + sign * corners[..., 0], 0.5 - corners[..., 1]], -1)
        sheets.append(_sheet(corners, np.broadcast_to((0.0, 0.0, sign), corners.shape), uv))
    return sheets


def _mapped_sphere() -> list[TexturedShape]:
    circle, part = _round()
    down = np.linspace(0.0, 1.0, _FROM_POLE_TO_POLE)
    height, radius = np.cos(np.pi * down), np.sin(np.pi * down)
    outwards = np.empty((len(down), len(part), 3))
    outwards[..., :2] = radius[:, None, None] * circle
    outwards[..., 2] = height[:, None]
    uv = np.stack(np.broadcast_arrays(part[None, :], down[:, None]), -1)
    return [_sheet(outwards / 2, outwards, uv)]


_MAPPED_MAKERS = {"box": _mapped_box, "cylinder": _mapped_cylinder, "sphere": _mapped_sphere}

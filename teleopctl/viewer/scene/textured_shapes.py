"""Boxes, cylinders and spheres of size 1, with the place of each corner in a picture.

A URDF names a picture for a shape and not where it goes. Each side of a box and each end of a
cylinder has the whole picture, upright; round a cylinder or a sphere it goes once, its middle
towards x. So Gazebo has it. RViz's shapes have a picture projected from their middle, by which
most sides of a box show a line of it, drawn out.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from teleopctl.viewer.scene.drawing import Floats

_AROUND, _FROM_POLE_TO_POLE = 48, 25


class MappedShape(NamedTuple):
    """Triangles with texture coordinates.

    Attributes:
        corners: Three for each, counter-clockwise from outside, shape (3 n, 3).
        normals: Where each looks, shape (3 n, 3).
        uv: Where each is in a picture, from its upper left, shape (3 n, 2).
    """

    corners: Floats
    normals: Floats
    uv: Floats


@functools.cache
def mapped_shape(name: str) -> MappedShape:
    """Return the triangles of a shape with texture coordinates.

    Args:
        name: ``box``; ``cylinder`` of diameter 1 and height 1 along z; ``sphere`` of diameter 1.

    Raises:
        KeyError: There is no such shape.
    """
    sheets = _MAKERS[name]()
    return MappedShape(*(np.concatenate(parts) for parts in zip(*sheets, strict=True)))


def _sheet(corners: Floats, normals: Floats, uv: Floats) -> MappedShape:
    """The triangles between rows of corners: downwards and, as seen from outside, to the right."""

    def between(grid: Floats) -> Floats:
        above, below = grid[:-1], grid[1:]
        left, right = slice(None, -1), slice(1, None)
        cells = [
            *(below[:, left], below[:, right], above[:, right]),
            *(below[:, left], above[:, right], above[:, left]),
        ]
        return np.stack(cells, axis=2).reshape(-1, grid.shape[-1])

    return MappedShape(between(corners), between(normals), between(uv))


def _box() -> list[MappedShape]:
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
    """Points of a circle of radius 1 from -x over -y, shape (n, 2), and what part of it is past."""
    part = np.linspace(0.0, 1.0, _AROUND + 1)
    angle = 2.0 * np.pi * part - np.pi
    return np.stack([np.cos(angle), np.sin(angle)], -1), part


def _cylinder() -> list[MappedShape]:
    circle, part = _round()
    flat = np.zeros((len(circle), 1))
    outwards = np.hstack([circle, flat])
    side = np.stack([outwards / 2 + (0, 0, 0.5), outwards / 2 - (0, 0, 0.5)])
    uv = np.stack([np.stack([part, np.full_like(part, v)], -1) for v in (0.0, 1.0)])
    sheets = [_sheet(side, np.stack([outwards, outwards]), uv)]
    for sign in (1.0, -1.0):
        # From outside the lower end goes round the other way.
        rim = circle[:: int(sign)] / 2
        corners = np.stack([np.hstack([ring, flat + sign / 2]) for ring in (0 * rim, rim)])
        uv = np.stack([0.5 + sign * corners[..., 0], 0.5 - corners[..., 1]], -1)
        sheets.append(_sheet(corners, np.broadcast_to((0.0, 0.0, sign), corners.shape), uv))
    return sheets


def _sphere() -> list[MappedShape]:
    circle, part = _round()
    down = np.linspace(0.0, 1.0, _FROM_POLE_TO_POLE)
    height, radius = np.cos(np.pi * down), np.sin(np.pi * down)
    outwards = np.empty((len(down), len(part), 3))
    outwards[..., :2] = radius[:, None, None] * circle
    outwards[..., 2] = height[:, None]
    uv = np.stack(np.broadcast_arrays(part[None, :], down[:, None]), -1)
    return [_sheet(outwards / 2, outwards, uv)]


_MAKERS = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}

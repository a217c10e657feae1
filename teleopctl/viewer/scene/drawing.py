"""Drawings of displays as arrays of numbers, which `Canvas` converts to viser scene nodes.

A drawing is in one frame; `Drawing.moved` transforms it to another.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from teleopctl.tf import Transform, matrix_from_quaternion, multiply, normalize

Floats = npt.NDArray[np.float64]
Rgba = tuple[float, float, float, float]
"""Red, green, blue and opacity, each from 0 to 1."""
Vector = tuple[float, float, float]

# Points beyond this distance are not drawn: 32-bit floats of browsers cannot distinguish them.
_FAR_M = 1e9
RED: Rgba = (1.0, 0.0, 0.0, 1.0)
GREEN: Rgba = (0.0, 1.0, 0.0, 1.0)
BLUE: Rgba = (0.0, 0.0, 1.0, 1.0)

OWN: Rgba = (0.7, 0.7, 0.7, 1.0)
"""Colour of a mesh drawn with its own materials; parts without material are grey."""

HAIR = 0.0
"""Width of lines that have the same width in pixels at any distance."""

# A solid is one row: position, rotation as w x y z, scale, colour.
COLUMNS = 14
_ALONG_X = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))
_ALONG_Y = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
_ALONG_Z = (0.0, 0.0, 0.0, 1.0)


@dataclass(slots=True)
class Rows:
    """Rows of numbers of a `Drawing`, added one by one or in blocks of shape (n, columns)."""

    single: list[tuple[float, ...]] = field(default_factory=list)
    blocks: list[Floats] = field(default_factory=list)

    def stack(self, columns: int) -> Floats:
        """Return all rows as one array, shape (n, columns)."""
        blocks = list(self.blocks)
        if self.single:
            blocks.append(np.array(self.single, np.float64))
        if len(blocks) == 1:
            return blocks[0]
        return np.vstack(blocks) if blocks else np.empty((0, columns))

    def add(self, other: Rows) -> None:
        """Append the rows of another `Rows` to this one."""
        self.single += other.single
        self.blocks += other.blocks


@dataclass(frozen=True, slots=True)
class Text:
    """Text of a `Drawing`, which faces the camera: position, text and height in metres."""

    position: Vector
    text: str
    height: float


@dataclass(frozen=True, slots=True)
class TriangleMesh:
    """Triangles of a `Drawing`, with a colour per corner, or a texture.

    Attributes:
        corners: Corners, three per triangle, (3 n, 3).
        colors: Red, green, blue and opacity from 0 to 1, (3 n, 4), or (4,) for all.
        pose: Pose of the corners' frame in the drawing.
        texture: Name of the texture; empty for none.
        uv: Texture coordinates of the corners, from the upper left, (3 n, 2).
    """

    corners: Floats
    colors: Floats
    pose: Transform = field(default_factory=Transform)
    texture: str = ""
    uv: Floats | None = None


@dataclass(slots=True)
class Drawing:
    """Solids, lines, points, texts and triangles in one frame, for a `Canvas` to show.

    Attributes:
        solids: Solids by the name of their shape, one of `unit_shapes` or a mesh's URI. Columns:
            position, rotation (w x y z), scale, colour (red, green, blue, opacity).
        lines: Lines by width in metres, or `HAIR`. Columns: start, its colour, end, its colour.
        points: Points by width in metres. Columns: position, colour.
        texts: Texts that face the camera.
        surfaces: Triangle meshes.
    """

    solids: dict[str, Rows] = field(default_factory=dict)
    lines: dict[float, Rows] = field(default_factory=dict)
    points: dict[float, Rows] = field(default_factory=dict)
    texts: list[Text] = field(default_factory=list)
    surfaces: list[TriangleMesh] = field(default_factory=list)

    def solid(self, shape: str, pose: Transform, scale: Vector, color: Rgba) -> None:
        """Add one solid by its shape's name, with pose, size along its axes, and colour."""
        x, y, z, w = pose.rotation
        row = (*pose.translation, w, x, y, z, *scale, *color)
        self.solids.setdefault(shape, Rows()).single.append(row)

    def solids_at(
        self, shape: str, positions: Floats, pose: Transform, scale: Vector, colors: Floats
    ) -> None:
        """Add solids of one shape, size and orientation at many positions.

        Args:
            shape: Name of the shape.
            positions: Positions in the frame of the pose, (n, 3).
            pose: Pose of that frame, and orientation of the solids.
            scale: Size of the solids along their axes.
            colors: Colours, (n, 4), or (4,) for all.
        """
        x, y, z, w = pose.rotation
        rows = np.empty((len(positions), COLUMNS))
        rows[:, 0:3] = moved_points(positions, pose)
        rows[:, 3:7] = (w, x, y, z)
        rows[:, 7:10] = scale
        rows[:, 10:14] = colors
        self.solids.setdefault(shape, Rows()).blocks.append(rows)

    def cylinder(
        self, pose: Transform, axis: str, length: float, diameter: float, color: Rgba
    ) -> None:
        """Add a cylinder from a pose's origin along the pose's ``x``, ``y`` or ``z`` axis."""
        turn = {"x": _ALONG_X, "y": _ALONG_Y, "z": _ALONG_Z}[axis]
        here = pose @ Transform((0.0, 0.0, 0.0), turn) @ Transform((0.0, 0.0, length / 2))
        self.solid("cylinder", here, (diameter, diameter, length), color)

    def axes(self, pose: Transform, length: float, radius: float, alpha: float = 1.0) -> None:
        """Add the axes of a pose as cylinders: x red, y green, z blue."""
        for along, color in (("x", RED), ("y", GREEN), ("z", BLUE)):
            self.cylinder(pose, along, length, 2 * radius, (*color[:3], alpha))

    def arrow(self, pose: Transform, size: ArrowSize, color: Rgba) -> None:
        """Add an arrow from a pose's origin along the pose's x axis."""
        turned = pose @ Transform((0.0, 0.0, 0.0), _ALONG_X)
        shaft, head = size.shaft_length, size.head_length
        if shaft > 0:
            middle = turned @ Transform((0.0, 0.0, shaft / 2))
            self.solid("cylinder", middle, (size.height or size.width, size.width, shaft), color)
        if head > 0:
            middle = turned @ Transform((0.0, 0.0, shaft + head / 2))
            ratio = size.head_width / size.width if size.width > 0 and size.height else 1.0
            across = size.height * ratio if size.height else size.head_width
            self.solid("cone", middle, (across, size.head_width, head), color)

    def line(self, points: Floats, colors: Floats, width: float, *, strip: bool) -> None:
        """Add a line strip through points, or separate line segments between pairs of points.

        Args:
            points: The strip's points, or the ends of the segments in pairs, (n, 3).
            colors: Colours of the points, (n, 4), or (4,) for all; opacity is ignored.
            width: Width in metres, or `HAIR`.
            strip: Whether the points are a strip.
        """
        colors = np.broadcast_to(colors, (len(points), 4))
        whole = np.hstack([points, colors[:, :3]])
        if strip:
            pairs = np.hstack([whole[:-1], whole[1:]])
        else:
            even = len(points) // 2 * 2
            pairs = np.hstack([whole[0:even:2], whole[1:even:2]])
        if len(pairs):
            self.lines.setdefault(width, Rows()).blocks.append(pairs)

    def dots(self, points: Floats, colors: Floats, width: float) -> None:
        """Add points, shape (n, 3), drawn as squares of ``width`` metres."""
        colors = np.broadcast_to(colors, (len(points), 4))
        if len(points):
            rows = np.hstack([points, colors[:, :3]])
            self.points.setdefault(width, Rows()).blocks.append(rows)

    def moved(self, pose: Transform) -> Drawing:
        """Return a copy of the drawing, transformed by a pose."""
        x, y, z, w = pose.rotation
        return self.copied_to(np.array([pose.translation]), np.array([[w, x, y, z]]))

    def copied_to(self, positions: Floats, rotations: Floats) -> Drawing:
        """Return a drawing with a copy of this drawing at each of many poses.

        Args:
            positions: Positions of the copies, (n, 3).
            rotations: Rotations of the copies as unit quaternions w x y z, (n, 4).
        """
        turns = _matrices(rotations)

        def place(points: Floats) -> Floats:
            placed: Floats = np.einsum("nij,mj->nmi", turns, points) + positions[:, None, :]
            return placed.reshape(-1, 3)

        out = Drawing()
        for shape, rows in self.solids.items():
            whole = rows.stack(COLUMNS)
            new = np.tile(whole, (len(positions), 1))
            new[:, 0:3] = place(whole[:, 0:3])
            new[:, 3:7] = _products(rotations, whole[:, 3:7])
            out.solids[shape] = Rows(blocks=[new])
        for width, rows in self.lines.items():
            whole = rows.stack(12)
            new = np.tile(whole, (len(positions), 1))
            new[:, 0:3], new[:, 6:9] = place(whole[:, 0:3]), place(whole[:, 6:9])
            out.lines[width] = Rows(blocks=[new])
        for width, rows in self.points.items():
            whole = rows.stack(6)
            new = np.tile(whole, (len(positions), 1))
            new[:, 0:3] = place(whole[:, 0:3])
            out.points[width] = Rows(blocks=[new])
        for text in self.texts:
            for px, py, pz in place(np.array([text.position])).tolist():
                out.texts.append(Text((px, py, pz), text.text, text.height))
        for surface in self.surfaces:
            for (px, py, pz), (w, x, y, z) in zip(
                positions.tolist(), rotations.tolist(), strict=True
            ):
                pose = Transform((px, py, pz), (x, y, z, w)) @ surface.pose
                out.surfaces.append(replace(surface, pose=pose))
        return out


@dataclass(frozen=True, slots=True)
class ArrowSize:
    """Lengths and widths of an arrow, in metres; a height makes it flatter or taller than wide."""

    shaft_length: float
    width: float
    head_length: float
    head_width: float
    height: float = 0.0


def merged(drawings: Iterable[Drawing]) -> Drawing:
    """Return one drawing with all parts of several drawings."""
    out = Drawing()
    for one in drawings:
        for shape, rows in one.solids.items():
            out.solids.setdefault(shape, Rows()).add(rows)
        for width, rows in one.lines.items():
            out.lines.setdefault(width, Rows()).add(rows)
        for width, rows in one.points.items():
            out.points.setdefault(width, Rows()).add(rows)
        out.texts += one.texts
        out.surfaces += one.surfaces
    return out


def is_drawable(numbers: Iterable[float]) -> bool:
    """Return whether all numbers are finite, and their absolute values add up to less than 1e9."""
    # A comparison with NaN is false. The sum takes a third of the time of checking each number.
    return sum(map(abs, numbers)) < _FAR_M


def drawable_rows(rows: Floats | npt.NDArray[np.float32]) -> npt.NDArray[np.bool_]:
    """Return a mask, (n,), of the rows whose numbers are all finite and below 1e9 in size."""
    # A comparison with NaN is false.
    drawable: npt.NDArray[np.bool_] = np.all(np.abs(rows) < _FAR_M, axis=1)
    return drawable


def unit_rotation(x: float, y: float, z: float, w: float) -> tuple[float, float, float, float]:
    """Return a quaternion x y z w normalised; the identity if all numbers are zero."""
    try:
        return normalize((x, y, z, w))
    except ZeroDivisionError:
        return (0.0, 0.0, 0.0, 1.0)


def moved_points(points: Floats, pose: Transform) -> Floats:
    """Return points, (n, 3), transformed by a pose, as a new array."""
    turn = np.array(matrix_from_quaternion(pose.rotation)).reshape(3, 3)
    out: Floats = points @ turn.T + np.array(pose.translation)
    return out


def pose_along(start: Sequence[float], end: Sequence[float]) -> tuple[Transform, float]:
    """Return a pose at ``start`` whose x axis points to ``end``, and the distance between them."""
    dx, dy, dz = (b - a for a, b in zip(start, end, strict=True))
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    yaw, pitch = math.atan2(dy, dx), math.atan2(-dz, math.hypot(dx, dy))
    turn = multiply(
        (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)),
        (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2)),
    )
    return Transform((start[0], start[1], start[2]), turn), length


def _matrices(rotations: Floats) -> Floats:
    """Rotation matrices, shape (n, 3, 3), of unit quaternions w x y z, shape (n, 4)."""
    w, x, y, z = rotations.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _products(first: Floats, second: Floats) -> Floats:
    """Each of n rotations w x y z after each of m, shape (n m, 4)."""
    aw, ax, ay, az = (part[:, None] for part in first.T)
    bw, bx, by, bz = second.T
    parts = [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
    return np.stack(parts, axis=-1).reshape(-1, 4)

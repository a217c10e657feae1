"""Objects of a planning scene as text, in the format of MoveIt's ``.scene`` files.

A line with the scene's name; for each object ``* NAME``, its pose, the number of its shapes, each
shape with its pose and colour (0 0 0 0 for none), the number of its subframes, each with its name
and pose; at the end a full stop. A pose is a line x y z and a line x y z w of a quaternion. Older
files have no poses and no subframes of objects.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np

from teleopctl.errors import InvalidFileError, UsageError
from teleopctl.kinematics import (
    CollisionBody,
    CollisionScene,
    CollisionShape,
    ShapeKind,
    pose_matrix,
    pose_transform,
)
from teleopctl.tf import Transform, normalize

Color = tuple[float, float, float, float]
# Words of the shapes, and the number of their numbers.
_WORDS = {
    "box": (ShapeKind.BOX, 3),
    "sphere": (ShapeKind.SPHERE, 1),
    "cylinder": (ShapeKind.CYLINDER, 2),
    "cone": (ShapeKind.CONE, 2),
    "plane": (ShapeKind.PLANE, 4),
}


def write_scene(scene: CollisionScene) -> str:
    """Return the objects around the robot as text; attached ones are left out, as in MoveIt."""
    lines = [scene.name]
    for one in scene.objects.values():
        color = " ".join(_number(value) for value in scene.colors.get(one.name, (0, 0, 0, 0)))
        lines += [f"* {one.name}", *_pose_lines(one.pose), str(len(one.shapes))]
        for shape, pose in zip(one.shapes, one.shape_poses, strict=True):
            lines += [*_shape_lines(shape), *_pose_lines(pose), color]
        lines.append(str(len(one.subframes)))
        for name, pose in one.subframes.items():
            lines += [name, *_pose_lines(pose)]
    return "\n".join([*lines, ".", ""])


def read_scene(file: Path) -> tuple[str, list[tuple[CollisionBody, Color | None]]]:
    """Return the name of a scene, and its objects with their colours.

    Raises:
        InvalidFileError: The file cannot be read, or has another format; with its line.
    """
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidFileError(f"{file} cannot be read: {error}") from error
    name, _, rest = text.partition("\n")
    words = _Words(file, rest)
    found: list[tuple[CollisionBody, Color | None]] = []
    while True:
        marker = words.word("'*' before an object, or '.' at the end")
        if marker == ".":
            return name.strip(), found
        if marker != "*":
            raise words.error(f"Expected '*' before an object, or '.' at the end, got '{marker}'")
        found.append(_read_object(words))


def _read_object(words: _Words) -> tuple[CollisionBody, Color | None]:
    name = words.rest_of_line()
    # Files of older versions continue with the number of shapes, alone in its line.
    is_old = words.words_in_next_line() == 1
    pose = np.eye(4) if is_old else words.pose(f"the pose of '{name}'")
    color: Color | None = None
    shapes, poses = [], []
    for _ in range(words.count(f"the number of shapes of '{name}'")):
        shapes.append(_read_shape(words))
        poses.append(words.pose(f"the pose of a shape of '{name}'"))
        r, g, b, a = words.numbers(4, f"the colour of a shape of '{name}'")
        if max(r, g, b, a) > 0.0:
            color = (r, g, b, a)
    subframes = {}
    if not is_old:
        for _ in range(words.count(f"the number of subframes of '{name}'")):
            subframe = words.word(f"the name of a subframe of '{name}'")
            subframes[subframe] = words.pose(f"the pose of '{name}/{subframe}'")
    return CollisionBody(name, pose, tuple(shapes), tuple(poses), subframes), color


def _read_shape(words: _Words) -> CollisionShape:
    word = words.word("a shape")
    try:
        if word == "mesh":
            vertices, triangles = (
                words.count(f"the number of {what} of a mesh") for what in ("vertices", "triangles")
            )
            points = words.numbers(3 * vertices, "the vertices of a mesh")
            corners = words.numbers(3 * triangles, "the triangles of a mesh")
            return CollisionShape.mesh(
                np.array(points).reshape(-1, 3), np.array(corners, np.intp).reshape(-1, 3)
            )
        if word not in _WORDS:
            known = ", ".join((*_WORDS, "mesh"))
            raise words.error(f"'{word}' is no shape: the shapes are {known}")
        kind, count = _WORDS[word]
        values = words.numbers(count, f"the dimensions of a {word}")
        if kind is ShapeKind.PLANE:
            return CollisionShape.plane(*values)
        if kind in (ShapeKind.CYLINDER, ShapeKind.CONE):
            # Radius and length here, height and radius in messages.
            values = values[::-1]
        return CollisionShape.primitive(kind, tuple(values))
    except UsageError as error:
        raise words.error(error.message) from error


class _Words:
    """Words of a text after its first line, with the lines in which they are.

    Args:
        file: The file, for messages.
        text: The text.
    """

    def __init__(self, file: Path, text: str) -> None:
        self._file = file
        self._lines = [line.split() for line in text.splitlines()]
        self._line, self._at = 0, 0

    def error(self, message: str) -> InvalidFileError:
        """Return an error about the line of the last word."""
        return InvalidFileError(message).at(f"{self._file}:{self._line + 2}")

    def word(self, what: str) -> str:
        """Return the next word."""
        while self._line < len(self._lines):
            words = self._lines[self._line]
            if self._at < len(words):
                self._at += 1
                return words[self._at - 1]
            self._line, self._at = self._line + 1, 0
        self._line = max(len(self._lines) - 1, 0)
        raise self.error(f"The file ends where {what} is expected")

    def rest_of_line(self) -> str:
        """Return the rest of the line of the last word."""
        words = self._lines[self._line][self._at :]
        self._at += len(words)
        return " ".join(words)

    def words_in_next_line(self) -> int:
        """Return the number of words in the next line that has any; 0 at the end."""
        return next(map(len, filter(None, self._lines[self._line + 1 :])), 0)

    def numbers(self, count: int, what: str) -> list[float]:
        """Return the next words as finite numbers."""
        values = []
        for _ in range(count):
            word = self.word(what)
            try:
                value = float(word)
            except ValueError:
                value = float("nan")
            if not np.isfinite(value):
                raise self.error(f"Expected a finite number for {what}, got '{word}'")
            values.append(value)
        return values

    def count(self, what: str) -> int:
        """Return the next word as a number of things."""
        word = self.word(what)
        if not word.isdecimal():
            raise self.error(f"Expected {what}, got '{word}'")
        return int(word)

    def pose(self, what: str) -> np.ndarray:
        """Return the next seven words as a pose, (4, 4)."""
        x, y, z, *turn = self.numbers(7, what)
        if not np.linalg.norm(turn) > 1e-6:
            raise self.error(f"The quaternion of {what} is zero, and no rotation")
        qx, qy, qz, qw = turn
        return pose_matrix(Transform((x, y, z), normalize((qx, qy, qz, qw))))


def _pose_lines(pose: np.ndarray) -> Iterator[str]:
    transform = pose_transform(pose)
    for values in (transform.translation, transform.rotation):
        yield " ".join(_number(value) for value in values)


def _shape_lines(shape: CollisionShape) -> Iterator[str]:
    if shape.kind is ShapeKind.MESH:
        assert shape.vertices is not None
        assert shape.triangles is not None
        yield from ("mesh", f"{len(shape.vertices)} {len(shape.triangles)}")
        for row in chain(shape.vertices.tolist(), shape.triangles.tolist()):
            yield " ".join(_number(value) for value in row)
        return
    values = shape.dimensions
    if shape.kind in (ShapeKind.CYLINDER, ShapeKind.CONE):
        values = values[::-1]
    yield shape.kind.name.lower()
    yield " ".join(_number(value) for value in values)


def _number(value: float) -> str:
    """Return the shortest text of a number that reads as the same one."""
    return str(int(value)) if float(value).is_integer() else repr(float(value))

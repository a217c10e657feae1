"""World files in teleopctl's YAML format: a few objects by shape and pose, lights and poses.

```yaml
world: kitchen
gravity: [0, 0, -9.81]
things:
  table: {shape: table, size: [0.9, 0.6, 0.4], at: [0.6, 0, 0]}
  cube: {shape: box, size: [0.05, 0.05, 0.05], at: [0.6, 0, 0.43], mass: 0.1, color: red}
lights:
- {kind: spot, at: [0, 0, 3], direction: [0, 0, -1]}
poses:
  shelf: {at: [1, 2, 0.4], tags: [spawn], description: free for a box, size: [0.3, 0.3, 0.3]}
```

Objects with a ``mass`` move freely, all others are static. Each mistake is reported with file and
line.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from teleopctl.base.printable import shortened
from teleopctl.base.ros_yaml import RosLoader, faults_of
from teleopctl.errors import InvalidDescriptionError, NotFoundError, did_you_mean
from teleopctl.packages import resolve_uri
from teleopctl.robot.gazebo_tag import gazebo_colour
from teleopctl.robot.scene.scene import (
    NOWHERE,
    Rgba,
    Scene,
    SceneBody,
    SceneLight,
    SceneModel,
    ScenePose,
    SceneShape,
    ShapeKind,
)
from teleopctl.robot.scene.surface import Surface
from teleopctl.tf import Transform, quaternion_from_rpy


@dataclass(frozen=True)
class YamlEntry:
    """Value in a world YAML file, with its key, file and line for error messages.

    Attributes:
        path: Path of the file.
        name: Name of the value in error messages.
        node: PyYAML's node, for the line.
        value: Parsed value.
    """

    path: Path
    name: str
    node: yaml.Node
    # Any: every type of YAML; the methods below check the type.
    value: Any

    @property
    def _is(self) -> str:
        """Text about the value for error messages: "is 5"."""
        return f"is {shortened(repr(self.value))}"

    def refuse(self, words: str) -> InvalidDescriptionError:
        """Return an error about the value, which begins with its file and line."""
        line = self.node.start_mark.line + 1
        return InvalidDescriptionError(f"{self.path}:{line}: {self.name} {words}")

    def entries(self, known: Iterable[str] | None = None) -> dict[str, YamlEntry]:
        """Return a mapping's entries by key; raise for keys outside `known`, if that is given.

        Raises:
            InvalidDescriptionError: The value is no mapping, or has an unknown or repeated key.
        """
        if not isinstance(self.node, yaml.MappingNode):
            raise self.refuse(f"should be a mapping, {self._is}")
        allowed = None if known is None else list(known)
        found: dict[str, YamlEntry] = {}
        for key, node in self.node.value:
            name = str(key.value)
            entry = YamlEntry(self.path, f"'{name}'", node, self.value.get(_key(key, self.value)))
            if allowed is not None and name not in allowed:
                line = key.start_mark.line + 1
                raise InvalidDescriptionError(
                    f"{self.path}:{line}: {self.name} has no '{name}'",
                    hint=did_you_mean(name, allowed) or f"It may have: {', '.join(allowed)}",
                )
            if name in found:
                raise entry.refuse("is given twice")
            found[name] = entry
        return found

    def items(self) -> list[YamlEntry]:
        """Return the entries of a list; raise if the value is no list.

        Raises:
            InvalidDescriptionError: The value is no list.
        """
        if not isinstance(self.node, yaml.SequenceNode):
            raise self.refuse(f"should be a list, {self._is}")
        return [
            YamlEntry(self.path, f"{self.name}[{number}]", node, value)
            for number, (node, value) in enumerate(zip(self.node.value, self.value, strict=True))
        ]

    def text(self) -> str:
        """Return the value as text; raise if it is no string or empty.

        Raises:
            InvalidDescriptionError: The value is no text, or empty.
        """
        if not isinstance(self.value, str) or not self.value:
            raise self.refuse(f"should be a text, {self._is}")
        return self.value

    def flag(self) -> bool:
        """Return the value as a bool; raise if it is neither true nor false.

        Raises:
            InvalidDescriptionError: The value is neither.
        """
        if not isinstance(self.value, bool):
            raise self.refuse(f"should be true or false, {self._is}")
        return self.value

    def number(self, *, positive: bool = False) -> float:
        """Return the value as a finite float; raise if it is no number.

        Raises:
            InvalidDescriptionError: The value is no finite number, or not positive as required.
        """
        value = self.value
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not math.isfinite(value) or (positive and value <= 0):
            kind = "a positive number" if positive else "a finite number"
            raise self.refuse(f"should be {kind}, {self._is}")
        return float(value)

    def numbers(self, *counts: int, positive: bool = False) -> tuple[float, ...]:
        """Return a list of finite numbers as a tuple; raise if its length is not a given one.

        Raises:
            InvalidDescriptionError: The length is not allowed, or an item is no valid number.
        """
        items = self.items() if isinstance(self.node, yaml.SequenceNode) else []
        if len(items) not in counts:
            wanted = " or ".join(map(str, counts))
            raise self.refuse(f"should be a list of {wanted} numbers, {self._is}")
        return tuple(item.number(positive=positive) for item in items)


def read_entries(path: Path, text: str) -> YamlEntry:
    """Parse YAML text; return its root value as a `YamlEntry`.

    Raises:
        InvalidDescriptionError: The text is empty or not valid YAML.
    """
    with faults_of(path, InvalidDescriptionError):
        loader = RosLoader(text)
        node = loader.get_single_node()
        value = None if node is None else loader.construct_document(node)
    if node is None:
        raise InvalidDescriptionError(f"{path}: it is empty")
    return YamlEntry(path, "the world", node, value)


def _key(node: yaml.Node, mapping: Any) -> Any:
    """Return the key of a mapping at a node, which YAML may have parsed as a number."""
    return next((key for key in mapping if str(key) == str(node.value)), node.value)


_WORLD = ("world", "gravity", "things", "lights", "poses")
_PLACE = ("at", "rpy")
_LOOK = ("color", "friction", "bounce", "mass")
_POSE = (*_PLACE, "description", "tags", "size")
_LIGHT = (*_PLACE, "kind", "direction", "color", "angle", "shadows")
# Keys of each shape in addition to those of pose, look and mass; the first is required.
_OF_SHAPE = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "ellipsoid": ("size",),
    "plane": ("size",),
    "mesh": ("file", "scale"),
    "heightfield": ("file", "size"),
    "table": ("size",),
    "bin": ("size", "thickness"),
    "ramp": ("size",),
    "walls": ("size", "thickness"),
}
_STANDS = ("plane", "heightfield")
_TOP_M, _LEG_M = 0.04, 0.05
_BIN_M, _WALL_M, _RAMP_M = 0.01, 0.1, 0.05
_WOOD: Rgba = (0.72, 0.58, 0.42, 1.0)

_Parts = list[SceneShape]


def read_yaml_world(path: Path, text: str) -> Scene:
    """Read a world in teleopctl's YAML format; return it as a `Scene`.

    Args:
        path: Path of the file; mesh files are relative to its folder.
        text: Content of the file.

    Raises:
        InvalidDescriptionError: The text is invalid; the message names file and line.
    """
    world = read_entries(path, text).entries(_WORLD)
    gravity = None
    if "gravity" in world:
        x, y, z = world["gravity"].numbers(3)
        gravity = (x, y, z)
    things = world["things"].entries() if "things" in world else {}
    lights = world["lights"].items() if "lights" in world else []
    poses = world["poses"].entries() if "poses" in world else {}
    name = next(iter(things)) if len(things) == 1 else path.stem
    if "world" in world:
        name = world["world"].text()
    return Scene(
        name,
        tuple(_thing(key, entry) for key, entry in things.items()),
        tuple(_light(entry) for entry in lights),
        gravity,
        files=(path,),
        is_model=len(things) == 1,
        poses=tuple(_pose(key, entry) for key, entry in poses.items()),
    )


def _pose(name: str, entry: YamlEntry) -> ScenePose:
    parts = entry.entries(_POSE)
    size = None
    if "size" in parts:
        x, y, z = parts["size"].numbers(3, positive=True)
        size = (x, y, z)
    return ScenePose(
        name,
        _place(parts),
        parts["description"].text() if "description" in parts else "",
        tuple(tag.text() for tag in parts["tags"].items()) if "tags" in parts else (),
        size,
    )


def _thing(name: str, entry: YamlEntry) -> SceneModel:
    if not isinstance(entry.value, dict) or "shape" not in entry.value:
        raise entry.refuse(f"should have a shape: {', '.join(_OF_SHAPE)}")
    shape = entry.value["shape"]
    if shape not in _OF_SHAPE:
        raise entry.entries()["shape"].refuse(f"is {shape!r}, should be {', '.join(_OF_SHAPE)}")
    parts = entry.entries(("shape", *_OF_SHAPE[shape], *_PLACE, *_LOOK))
    for required in _OF_SHAPE[shape][:1] if shape != "plane" else ():
        if required not in parts:
            raise entry.refuse(f"lacks its {required}")
    mass = parts["mass"].number(positive=True) if "mass" in parts else None
    if mass is not None and shape in _STANDS:
        raise parts["mass"].refuse(f"is not allowed for a {shape}, which is static")
    shapes = _shapes(shape, entry, parts)
    rgba = _color(parts["color"]) if "color" in parts else None
    friction = parts["friction"].number() if "friction" in parts else None
    if friction is not None and friction < 0.0:
        raise parts["friction"].refuse("should not be negative")
    bounce = parts["bounce"].number() if "bounce" in parts else 0.0
    if not 0.0 <= bounce <= 1.0:
        raise parts["bounce"].refuse("should be from 0 to 1")
    volume = sum(map(_volume, shapes))
    made = tuple(
        SceneShape(
            part.kind,
            part.size,
            part.pose,
            file=part.file,
            rgba=rgba or part.rgba,
            friction=friction,
            surface=Surface(bounce) if bounce else None,
            mass=None if mass is None else mass * _volume(part) / volume,
        )
        for part in shapes
    )
    body = SceneBody(name, NOWHERE, made)
    return SceneModel(name, _place(parts), {name: body}, static=mass is None)


def _shapes(shape: str, entry: YamlEntry, parts: dict[str, YamlEntry]) -> _Parts:
    """Return the shapes of an object, in the object's frame."""
    match shape:
        case "sphere":
            return [SceneShape("sphere", (parts["radius"].number(positive=True), 0.0, 0.0))]
        case "cylinder" | "capsule":
            if "length" not in parts:
                raise entry.refuse("lacks its length")
            radius = parts["radius"].number(positive=True)
            size = (radius, parts["length"].number(positive=True), 0.0)
            return [SceneShape("cylinder" if shape == "cylinder" else "capsule", size)]
        case "plane":
            sides = parts["size"].numbers(2, positive=True) if "size" in parts else (0.0, 0.0)
            return [SceneShape("plane", (sides[0], sides[1], 0.0))]
        case "mesh":
            scale = parts.get("scale")
            factors = (1.0, 1.0, 1.0)
            if scale is not None and isinstance(scale.value, list):
                x, y, z = scale.numbers(3)
                factors = (x, y, z)
            elif scale is not None:
                factors = (scale.number(positive=True),) * 3
            return [SceneShape("mesh", factors, file=_file(parts["file"]))]
        case "heightfield":
            if "size" not in parts:
                raise entry.refuse("lacks its size")
            x, y, z = parts["size"].numbers(3, positive=True)
            return [SceneShape("heightmap", (x, y, z), file=_file(parts["file"]))]
    x, y, z = parts["size"].numbers(3, positive=True)
    if shape in ("box", "ellipsoid"):
        kind: ShapeKind = "box" if shape == "box" else "ellipsoid"
        half = 1.0 if shape == "box" else 0.5
        return [SceneShape(kind, (half * x, half * y, half * z))]
    thick = parts["thickness"].number(positive=True) if "thickness" in parts else None
    return _furniture(shape, x, y, z, thick, entry)


def _furniture(
    shape: str, x: float, y: float, z: float, thick: float | None, entry: YamlEntry
) -> _Parts:
    """Return the boxes of a table, bin, ramp or walls; the origin is the middle of the foot."""
    match shape:
        case "table":
            if z <= _TOP_M or min(x, y) <= 2 * _LEG_M:
                raise entry.refuse(
                    f"is not a valid table: the top is {_TOP_M} m thick, a leg {_LEG_M} m"
                )
            top = _box(x, y, _TOP_M, 0.0, 0.0, z - _TOP_M / 2, _WOOD)
            across, along = (x - _LEG_M) / 2, (y - _LEG_M) / 2
            height = z - _TOP_M
            return [top] + [
                _box(_LEG_M, _LEG_M, height, i * across, j * along, height / 2, _WOOD)
                for i in (-1, 1)
                for j in (-1, 1)
            ]
        case "bin":
            wall = thick or _BIN_M
            if 2 * wall >= min(x, y) or wall >= z:
                raise entry.refuse(f"is not a valid bin: its walls are {wall} m thick")
            return [_box(x, y, wall, 0.0, 0.0, wall / 2), *_four_walls(x, y, z, wall, inside=True)]
        case "walls":
            return _four_walls(x, y, z, thick or _WALL_M, inside=False)
    # A ramp: its upper side rises from the ground at -x/2 to its height at x/2.
    angle, length = math.atan2(z, x), math.hypot(x, z)
    turn = quaternion_from_rpy(0.0, -angle, 0.0)
    below = Transform((0.0, 0.0, -_RAMP_M / 2))
    pose = Transform((0.0, 0.0, z / 2), turn) @ below
    return [SceneShape("box", (length, y, _RAMP_M), pose)]


def _four_walls(x: float, y: float, z: float, thick: float, *, inside: bool) -> _Parts:
    """Return four walls around a room, or with ``inside`` within the outline of a bin."""
    inner_x, inner_y = (x - 2 * thick, y - 2 * thick) if inside else (x, y)
    across, along = (inner_x + thick) / 2, (inner_y + thick) / 2
    return [
        *(_box(thick, inner_y + 2 * thick, z, i * across, 0.0, z / 2) for i in (-1, 1)),
        *(_box(inner_x, thick, z, 0.0, j * along, z / 2) for j in (-1, 1)),
    ]


def _box(
    x: float, y: float, z: float, at_x: float, at_y: float, at_z: float, rgba: Rgba | None = None
) -> SceneShape:
    return SceneShape("box", (x, y, z), Transform((at_x, at_y, at_z)), rgba=rgba)


def _volume(shape: SceneShape) -> float:
    """Return the volume of a box in m³; 1 for other shapes, each the only one of its object."""
    a, b, c = shape.size
    return a * b * c if shape.kind == "box" else 1.0


def _place(parts: dict[str, YamlEntry]) -> Transform:
    x, y, z = parts["at"].numbers(3) if "at" in parts else (0.0, 0.0, 0.0)
    roll, pitch, yaw = parts["rpy"].numbers(3) if "rpy" in parts else (0.0, 0.0, 0.0)
    return Transform((x, y, z), quaternion_from_rpy(roll, pitch, yaw))


def _color(entry: YamlEntry) -> Rgba:
    if isinstance(entry.value, str):
        named = gazebo_colour(entry.value)
        if named is None:
            raise entry.refuse(f"is {entry.value!r}: not a colour name; use [red, green, blue]")
        return *named, 1.0
    parts = entry.numbers(3, 4)
    if not all(0.0 <= part <= 1.0 for part in parts):
        raise entry.refuse("should be numbers from 0 to 1")
    red, green, blue, *alpha = parts
    return red, green, blue, alpha[0] if alpha else 1.0


def _file(entry: YamlEntry) -> Path:
    try:
        path = entry.path.parent / resolve_uri(entry.text())
        is_there = path.is_file()
    except (NotFoundError, OSError) as error:
        raise entry.refuse(f"is not found: {error}") from error
    if not is_there:
        raise entry.refuse(f"is not found: {path} is not a file")
    return path.absolute()


def _light(entry: YamlEntry) -> SceneLight:
    parts = entry.entries(_LIGHT)
    kind = parts["kind"].text() if "kind" in parts else "directional"
    color = _color(parts["color"])[:3] if "color" in parts else (0.5, 0.5, 0.5)
    x, y, z = parts["direction"].numbers(3) if "direction" in parts else (0.0, 0.0, -1.0)
    if not any((x, y, z)):
        raise parts["direction"].refuse("has no length")
    angle = parts["angle"].number(positive=True) if "angle" in parts else 0.8
    shadows = parts["shadows"].flag() if "shadows" in parts else True
    match kind:
        case "directional" | "point" | "spot":
            return SceneLight(kind, _place(parts), (x, y, z), color, angle, shadows)
    raise parts["kind"].refuse(f"is {kind!r}, should be directional, point or spot")

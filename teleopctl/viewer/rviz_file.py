"""``.rviz`` files: displays, fixed frame and view, read and written as RViz has them.

Nothing that stands in a file is lost: what is not understood stays where it is and is written back.
A display's properties are a part of the document, so that setting one changes what is saved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.base.files import read_text
from teleopctl.base.ros_yaml import RosLoader, faults_of, load
from teleopctl.errors import TeleopctlError
from teleopctl.tf import Vector3

_MANAGER = "Visualization Manager"
_GROUP = "rviz_common/Group"
_PACKAGE = "rviz_default_plugins"
# What ROS 1 calls otherwise.
_RENAMED = {"WrenchStamped": "Wrench"}
_ROOT_FRAME = "<Fixed Frame>"
# Where RViz looks from in a new file.
_DISTANCE_M = 10.0
_QUARTER = math.pi / 4
# What a picture of RViz is high, in pixels, and viser's opening angle: for orthographic views.
_HEIGHT_PX = 800.0
_FOV_RAD = math.radians(75.0)
# Straight down, a camera has no direction that is up.
_STEEPEST_RAD = math.radians(89.9)

# Any stands for what YAML holds.

Lines = dict[tuple[int, Any], int]
"""Lines of a file by the mapping's identity and the key."""


class RvizFileError(TeleopctlError):
    """A file is no valid ``.rviz`` file; the message names it."""


class View(NamedTuple):
    """Position and focal point of the camera, in the view's target frame; metres.

    Attributes:
        eye: Where the camera is.
        focus: What it looks at.
    """

    eye: Vector3
    focus: Vector3


class DisplayEntry(NamedTuple):
    """A display in an ``.rviz`` file.

    Attributes:
        rviz_class: Its class without the package.
        name: What the user calls it.
        given: Its part of the document, which is changed in place.
        in_shown_group: Whether the groups that it is in are shown.
    """

    rviz_class: str
    name: str
    given: dict[str, Any]
    in_shown_group: bool


class RvizFile:
    """An ``.rviz`` file.

    Args:
        document: What the file holds; None for a new one.
        lines: The lines of its keys; see `line_of`.
    """

    def __init__(self, document: dict[str, Any] | None = None, lines: Lines | None = None) -> None:
        self.document: dict[str, Any] = {} if document is None else document
        self._lines: Lines = lines or {}
        self._manager = _inner(self.document, _MANAGER)

    @classmethod
    def load(cls, path: Path) -> RvizFile:
        """Read an ``.rviz`` file.

        Raises:
            TeleopctlError: It cannot be read, or is no ``.rviz`` file.
        """
        import yaml

        text = read_text(path)
        with faults_of(path, RvizFileError):
            document = load(text)
        if not isinstance(document, dict) or not isinstance(document.get(_MANAGER), dict):
            raise RvizFileError(
                f"{path} is no .rviz file", hint=f"It has no '{_MANAGER}' at its beginning."
            )
        lines: Lines = {}
        _find_lines(document, yaml.compose(text, Loader=RosLoader), lines)
        return cls(document, lines)

    def text(self) -> str:
        """Return the file's YAML, as RViz reads it."""
        import yaml

        return yaml.safe_dump(self.document, sort_keys=False, allow_unicode=True)

    def line_of(self, mapping: dict[str, Any], key: str) -> int | None:
        """Return the line of a key in one of the file's mappings, or None."""
        return self._lines.get((id(mapping), key))

    # --- displays -----------------------------------------------------------------------------

    def displays(self) -> list[DisplayEntry]:
        """Return the displays, also those in groups, in their order."""
        return list(_entries(self._displays(), shown=True))

    def add(self, rviz_class: str, name: str, given: dict[str, Any]) -> None:
        """Add a display to the document."""
        given.setdefault("Class", f"{_PACKAGE}/{rviz_class}")
        given.setdefault("Name", name)
        given.setdefault("Enabled", True)
        given.setdefault("Value", given["Enabled"])
        self._displays().append(given)

    def remove(self, given: dict[str, Any]) -> None:
        """Remove a display from the file, in whatever group it is."""
        _remove(self._displays(), given)

    def _displays(self) -> list[Any]:
        displays = self._manager.get("Displays")
        if not isinstance(displays, list):
            displays = self._manager["Displays"] = []
        return displays

    # --- the whole ----------------------------------------------------------------------------

    @property
    def fixed_frame(self) -> str:
        """Fixed frame; empty if the file has none."""
        name = _inner(self._manager, "Global Options").get("Fixed Frame")
        return name.removeprefix("/") if isinstance(name, str) else ""

    @fixed_frame.setter
    def fixed_frame(self, name: str) -> None:
        _inner(self._manager, "Global Options")["Fixed Frame"] = name

    @property
    def background(self) -> tuple[int, int, int] | None:
        """Background colour, each part from 0 to 255."""
        text = str(_inner(self._manager, "Global Options").get("Background Color", ""))
        try:
            red, green, blue = (min(max(int(part), 0), 255) for part in text.split(";"))
        except ValueError:
            return None
        return red, green, blue

    def tools(self) -> list[dict[str, Any]]:
        """Return the tools of the file."""
        tools = self._manager.get("Tools")
        return [one for one in tools if isinstance(one, dict)] if isinstance(tools, list) else []

    @property
    def current_view(self) -> dict[str, Any]:
        """The current view of the file, as a mapping."""
        current = _inner(self._manager, "Views").get("Current")
        return current if isinstance(current, dict) else {}

    @property
    def view(self) -> View | None:
        """Return the camera's position and focal point; None if the file has no view."""
        return _view(self.current_view) if self.current_view else None

    @view.setter
    def view(self, view: View) -> None:
        current = _inner(_inner(self._manager, "Views"), "Current")
        dx, dy, dz = (eye - focus for eye, focus in zip(view.eye, view.focus, strict=True))
        distance = math.dist(view.eye, view.focus) or _DISTANCE_M
        current.update(
            {
                "Class": f"{_PACKAGE}/Orbit",
                "Distance": distance,
                "Focal Point": dict(zip("XYZ", view.focus, strict=True)),
                "Pitch": math.asin(max(-1.0, min(1.0, dz / distance))),
                "Yaw": math.atan2(dy, dx) % math.tau,
                "Target Frame": _ROOT_FRAME,
                "Value": "Orbit (rviz_default_plugins)",
            }
        )
        current.setdefault("Name", "Current View")


def plain_class(name: str) -> str:
    """Return a class's name without its package, such as TF for ``rviz/TF``."""
    return name.rpartition("/")[2]


def _find_lines(value: Any, node: Any, found: Lines) -> None:
    """Note the lines of all keys of what has been made from a node of PyYAML."""
    # A key that is there twice, or merged from elsewhere, leaves the two different.
    if isinstance(value, dict) and len(value) == len(node.value):
        for key, (key_node, inner) in zip(value, node.value, strict=True):
            found[id(value), key] = key_node.start_mark.line + 1
            _find_lines(value[key], inner, found)
    elif isinstance(value, list):
        for one, inner in zip(value, node.value, strict=True):
            _find_lines(one, inner, found)


def _inner(mapping: dict[str, Any], key: str) -> dict[str, Any]:
    inner = mapping.get(key)
    if not isinstance(inner, dict):
        inner = mapping[key] = {}
    return inner


def _entries(displays: list[Any], *, shown: bool) -> Iterator[DisplayEntry]:
    for given in displays:
        if not isinstance(given, dict) or not isinstance(given.get("Class"), str):
            continue
        rviz_class = plain_class(given["Class"])
        inner = given.get("Displays")
        if rviz_class == plain_class(_GROUP):
            enabled = shown and given.get("Enabled", True) is not False
            yield from _entries(inner if isinstance(inner, list) else [], shown=enabled)
        else:
            name = given.get("Name")
            named = name if isinstance(name, str) else rviz_class
            yield DisplayEntry(_RENAMED.get(rviz_class, rviz_class), named, given, shown)


def _remove(displays: list[Any], given: dict[str, Any]) -> None:
    for index, other in enumerate(displays):
        if other is given:
            del displays[index]
            return
        if isinstance(other, dict) and isinstance(other.get("Displays"), list):
            _remove(other["Displays"], given)


def _view(current: dict[str, Any]) -> View:
    yaw, pitch = _number(current, "Yaw", _QUARTER), _number(current, "Pitch", _QUARTER)
    pitch = max(-_STEEPEST_RAD, min(_STEEPEST_RAD, pitch))
    ahead = (
        math.cos(pitch) * math.cos(yaw),
        math.cos(pitch) * math.sin(yaw),
        math.sin(pitch),
    )
    kind = plain_class(str(current.get("Class")))
    if kind == "TopDownOrtho":
        x, y = _number(current, "X", 0.0), _number(current, "Y", 0.0)
        scale = _number(current, "Scale", 10.0) or 10.0
        height = _HEIGHT_PX / abs(scale) / 2 / math.tan(_FOV_RAD / 2)
        # a hair off the vertical, so that y points up in the picture
        return View((x, y - height * math.cos(_STEEPEST_RAD), height), (x, y, 0.0))
    if kind == "FPS":
        eye = _vector(current, "Position")
        x, y, z = (part + step for part, step in zip(eye, ahead, strict=True))
        return View(eye, (x, y, 2 * eye[2] - z))
    focus = _vector(current, "Focal Point")
    distance = abs(_number(current, "Distance", _DISTANCE_M)) or _DISTANCE_M
    x, y, z = (part + distance * step for part, step in zip(focus, ahead, strict=True))
    return View((x, y, z), focus)


def _vector(mapping: dict[str, Any], key: str) -> Vector3:
    inner = mapping.get(key)
    inner = inner if isinstance(inner, dict) else {}
    return (_number(inner, "X", 0.0), _number(inner, "Y", 0.0), _number(inner, "Z", 0.0))


def _number(mapping: dict[str, Any], key: str, default: float) -> float:
    value = mapping.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return default
    return float(value)

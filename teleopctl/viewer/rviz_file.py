"""``.rviz`` files: displays, fixed frame and view, as RViz reads and writes them.

Nothing in a file is lost: unknown parts stay in the document and are written back. A display's
properties are a part of the document, so setting one changes what is saved.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.base.files import read_text
from teleopctl.base.printable import printable_line
from teleopctl.base.ros_yaml import RosLoader, faults_of, load
from teleopctl.errors import TeleopctlError
from teleopctl.tf import Vector3
from teleopctl.viewer.displays.base import Display

_MANAGER = "Visualization Manager"
_GROUP = "rviz_common/Group"
_PACKAGE = "rviz_default_plugins"
# Classes with another name in ROS 1.
_RENAMED = {"WrenchStamped": "Wrench"}
_ROOT_FRAME = "<Fixed Frame>"
# Camera distance and angles in a new file of RViz.
_DISTANCE_M = 10.0
_QUARTER = math.pi / 4
# Height of RViz's picture in pixels, and viser's field of view, to convert orthographic views.
_HEIGHT_PX = 800.0
_FOV_RAD = math.radians(75.0)
# A camera that looks straight down has no up direction.
_STEEPEST_RAD = math.radians(89.9)

# Any: YAML values.

Lines = dict[tuple[int, Any], int]
"""Line numbers of the keys in a file, by `id` of the mapping and key."""


class RvizFileError(TeleopctlError):
    """Error: a file is no valid ``.rviz`` file; the text has its path."""


class View(NamedTuple):
    """Camera of the 3D view: position and focal point, in metres.

    Attributes:
        eye: Position of the camera.
        focus: Focal point.
    """

    eye: Vector3
    focus: Vector3


class DisplayEntry(NamedTuple):
    """Display in an ``.rviz`` file: class, name, and mapping of properties.

    Attributes:
        rviz_class: RViz class of the display, without package.
        name: Name of the display in the list of displays.
        given: Mapping of the display in the document, changed in place.
        in_shown_group: Whether all groups that contain the display are enabled.
    """

    rviz_class: str
    name: str
    given: dict[str, Any]
    in_shown_group: bool


class RvizFile:
    """Content of an ``.rviz`` file: displays, fixed frame, tools and view.

    Args:
        document: Parsed YAML of the file; None for a new file.
        lines: Line numbers of the document's keys; see `line_of`.
    """

    def __init__(self, document: dict[str, Any] | None = None, lines: Lines | None = None) -> None:
        self.document: dict[str, Any] = {} if document is None else document
        self._lines: Lines = lines or {}
        self._manager = _inner(self.document, _MANAGER)

    @classmethod
    def load(cls, path: Path) -> RvizFile:
        """Return the content of an ``.rviz`` file; raise RvizFileError if it is not one.

        Raises:
            TeleopctlError: The file cannot be read, or is no ``.rviz`` file.
        """
        return cls.parse(read_text(path), path)

    @classmethod
    def parse(cls, text: str, path: Path) -> RvizFile:
        """Return the content of the text of an ``.rviz`` file.

        Args:
            text: The text.
            path: The file that has the text, for error messages.

        Raises:
            TeleopctlError: The text is not that of an ``.rviz`` file.
        """
        import yaml

        with faults_of(path, RvizFileError):
            document = load(text)
        if not isinstance(document, dict) or not isinstance(document.get(_MANAGER), dict):
            raise RvizFileError(
                f"{path} is not an .rviz file", hint=f"It does not start with '{_MANAGER}'."
            )
        lines: Lines = {}
        _find_lines(document, yaml.compose(text, Loader=RosLoader), lines)
        return cls(document, lines)

    def text(self) -> str:
        """Return the ``.rviz`` document as YAML text, which RViz can read."""
        import yaml

        return yaml.safe_dump(self.document, sort_keys=False, allow_unicode=True)

    def line_of(self, mapping: dict[str, Any], key: str) -> int | None:
        """Return the line number of a key in a mapping of the ``.rviz`` file; None if unknown."""
        return self._lines.get((id(mapping), key))

    # --- displays -----------------------------------------------------------------------------

    def displays(self) -> list[DisplayEntry]:
        """Return all displays of the ``.rviz`` document in order, those in groups included."""
        return list(_entries(self._displays(), shown=True))

    def add(self, rviz_class: str, name: str, mapping: dict[str, Any]) -> None:
        """Append a display's mapping to the ``.rviz`` document, with class and name if missing."""
        mapping.setdefault("Class", f"{_PACKAGE}/{rviz_class}")
        mapping.setdefault("Name", name)
        mapping.setdefault("Enabled", True)
        mapping.setdefault("Value", mapping["Enabled"])
        self._displays().append(mapping)

    def remove(self, mapping: dict[str, Any]) -> None:
        """Remove a display from the ``.rviz`` document, also from a group, by its mapping."""
        _remove(self._displays(), mapping)

    def _displays(self) -> list[Any]:
        displays = self._manager.get("Displays")
        if not isinstance(displays, list):
            displays = self._manager["Displays"] = []
        return displays

    # --- global options and view --------------------------------------------------------------

    @property
    def fixed_frame(self) -> str:
        """Fixed frame in the ``.rviz`` document; empty if the document has none."""
        name = _inner(self._manager, "Global Options").get("Fixed Frame")
        return name.removeprefix("/") if isinstance(name, str) else ""

    @fixed_frame.setter
    def fixed_frame(self, name: str) -> None:
        _inner(self._manager, "Global Options")["Fixed Frame"] = name

    @property
    def background(self) -> tuple[int, int, int] | None:
        """Background colour, each part from 0 to 255; None if the ``.rviz`` document has none."""
        text = str(_inner(self._manager, "Global Options").get("Background Color", ""))
        try:
            red, green, blue = (min(max(int(part), 0), 255) for part in text.split(";"))
        except ValueError:
            return None
        return red, green, blue

    def tools(self) -> list[dict[str, Any]]:
        """Return the mappings of the ``.rviz`` document's tools, such as ``SetGoal``."""
        tools = self._manager.get("Tools")
        return [one for one in tools if isinstance(one, dict)] if isinstance(tools, list) else []

    @property
    def current_view(self) -> dict[str, Any]:
        """Mapping of the ``.rviz`` document's current view; empty if the document has none."""
        current = _inner(self._manager, "Views").get("Current")
        return current if isinstance(current, dict) else {}

    @property
    def view(self) -> View | None:
        """Camera position and focal point of the current view; None if there is none."""
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


def class_without_package(name: str) -> str:
    """Return the name of an RViz class without its package: ``TF`` for ``rviz/TF``."""
    return name.rpartition("/")[2]


def _find_lines(value: Any, node: Any, found: Lines) -> None:
    """Add the lines of all keys of a parsed value to a dict, from its PyYAML node."""
    # With a duplicate or merged key, value and node have different numbers of items.
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
        rviz_class = class_without_package(given["Class"])
        inner = given.get("Displays")
        if rviz_class == class_without_package(_GROUP):
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
    kind = class_without_package(str(current.get("Class")))
    if kind == "TopDownOrtho":
        x, y = _number(current, "X", 0.0), _number(current, "Y", 0.0)
        scale = _number(current, "Scale", 10.0) or 10.0
        height = _HEIGHT_PX / abs(scale) / 2 / math.tan(_FOV_RAD / 2)
        # slightly off the vertical, so that y points up in the picture
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


# RViz's defaults that are not zero, empty or false.
_DEFAULTS: Mapping[str, Any] = {
    "Accept NaN Values": False,
    "Binary threshold": 100,
    "Enable Transparency": True,
    "Far Plane Distance": 100,
    "Image Rendering": "background and overlay",
    "Occlusion Compensation": {"Occlusion Time-Out": 30, "Value": False},
    "Line Style": {"Line Width": 0.03, "Value": "Lines"},
    "Overlay Alpha": 0.5,
    "Show Robot Visual": True,
    "Zoom Factor": 1,
}
# Properties that have an equivalent, or that belong to the windows of RViz or MoveIt.
_IGNORED = frozenset(
    {
        *("Class", "Enabled", "Name", "Value", "Topic", "Links", "Namespaces", "Tree"),
        *("Position Transformer", "Queue Size", "Selectable", "Transport Hint", "Unreliable"),
        *("Marker Topic", "Image Topic", "Description Topic", "Robot Description", "Update Topic"),
        *("Update Interval", "Trajectory Topic", "Planning Group", "Planning Metrics"),
        *("Acceleration_Scaling_Factor", "Velocity_Scaling_Factor", "Use Sim Time"),
        *("Voxel Coloring", "Voxel Rendering", "Scene Display Time", "Show Workspace"),
        *("Reliability Policy", "Topic Filter"),
        *("Colliding Link Color", "Joint Violation Color", "Interactive Marker Size"),
        *("Show Arrows", "Start State Alpha", "Start State Color", "Frames"),
    }
)
_MOVEIT_WINDOW = ("MoveIt_", "JointsTab_")
_PANELS = frozenset({"Displays", "Help", "Selection", "Time", "Tool Properties", "Views"})
_TOOLS = frozenset(
    {
        *("FocusCamera", "Interact", "Measure", "MoveCamera", "Select"),
        *("PublishPoint", "SetGoal", "SetInitialPose"),
    }
)
_VIEWS = frozenset({"FPS", "Orbit", "ThirdPersonFollower", "TopDownOrtho", "XYOrbit"})
_RVIZ = ("rviz_common/", "rviz_default_plugins/", "rviz/")
# More parts make the line unreadable.
_MOST_LISTED = 12


def unsupported_text(file: RvizFile, path: Path, displays: Sequence[Display]) -> str:
    """Return a line on the parts of an ``.rviz`` file that have no effect; empty for none.

    RViz writes every property of every display: properties at their defaults are not listed.

    Args:
        file: Content of the file.
        path: Path of the file.
        displays: Displays created from the file.
    """
    parts = [
        *_unknown_displays(file, displays),
        *(part for display in displays for part in _unknown_properties(file, display)),
        *_unknown_classes("panel", file.document.get("Panels"), _PANELS),
        *_unknown_classes("tool", file.tools(), _TOOLS),
        *_unknown_view(file.current_view),
    ]
    if not parts:
        return ""
    more = f"; and {len(parts) - _MOST_LISTED} more" if len(parts) > _MOST_LISTED else ""
    return f"{path}: not shown, and kept when it is saved: {'; '.join(parts[:_MOST_LISTED])}{more}"


def _unknown_displays(file: RvizFile, displays: Sequence[Display]) -> Iterator[str]:
    known = {id(display.values.given) for display in displays}
    first: dict[str, int | None] = {}
    for entry in file.displays():
        if id(entry.given) not in known:
            first.setdefault(entry.rviz_class, file.line_of(entry.given, "Class"))
    if first:
        named = ", ".join(f"{name}{_line_text(line)}" for name, line in first.items())
        yield f"displays of class {printable_line(named)}"


def _unknown_properties(file: RvizFile, display: Display) -> Iterator[str]:
    known = {property_.name for property_ in display.properties} | {display.topic_key}
    found = list(_unsupported(file, display.values.given, known, ""))
    if found:
        names = ", ".join(name for name, _ in found)
        yield printable_line(f"{names} of '{display.name}'{_line_text(found[0][1])}")


def _unsupported(
    file: RvizFile, given: dict[str, Any], known: set[str], above: str
) -> Iterator[tuple[str, int | None]]:
    """Yield the unknown properties that are not at their default, each with its line."""
    for key, value in given.items():
        name = f"{above}{key}"
        if key in _IGNORED or name in known or str(key).startswith(_MOVEIT_WINDOW):
            continue
        if isinstance(value, dict) and any(one.startswith(f"{name}/") for one in known):
            yield from _unsupported(file, value, known, f"{name}/")
        elif _has_effect(str(key), value):
            yield name, file.line_of(given, key)


def _has_effect(key: str, value: Any) -> bool:
    """Return whether a property has another value than RViz's default."""
    if key == "Visibility":
        # RViz lists all displays here; only disabled ones change the picture.
        return _has_false(value)
    if key in _DEFAULTS:
        return not _same(value, _DEFAULTS[key])
    if isinstance(value, dict):
        return any(_has_effect(str(inner), one) for inner, one in value.items())
    return bool(value)


def _has_false(value: Any) -> bool:
    if isinstance(value, dict):
        return any(_has_false(one) for one in value.values())
    return value is False


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, int | float) and isinstance(other, int | float):
        # RViz stores 32-bit floats.
        return math.isclose(one, other, rel_tol=1e-6)
    return bool(one == other)


def _unknown_classes(what: str, listed: Any, known: frozenset[str]) -> Iterator[str]:
    """Yield a text about the classes of a list that have no equivalent."""
    entries: Iterable[Any] = listed if isinstance(listed, list) else ()
    names = [str(one.get("Class", "")) for one in entries if isinstance(one, dict)]
    unknown = dict.fromkeys(name for name in names if name and not _is_rviz(name, known))
    if unknown:
        many = "s" if len(unknown) > 1 else ""
        yield printable_line(f"{what}{many} {', '.join(unknown)}")


def _is_rviz(name: str, known: frozenset[str]) -> bool:
    return name.startswith(_RVIZ) and class_without_package(name) in known


def _unknown_view(current: dict[str, Any]) -> Iterator[str]:
    yield from _unknown_classes("view controller", [current], _VIEWS)
    target = current.get("Target Frame")
    if isinstance(target, str) and target not in ("", "<Fixed Frame>"):
        yield printable_line(f"target frame '{target}' of the view")


def _line_text(line: int | None) -> str:
    return "" if line is None else f" (line {line})"

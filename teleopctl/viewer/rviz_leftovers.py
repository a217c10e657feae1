"""What an ``.rviz`` file asks for and the page does not do: told in one line.

RViz writes every property of every display. Those at their defaults ask for nothing, and a line
that names them all would be read by nobody.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from teleopctl.base.printable import printable_line
from teleopctl.viewer.displays.base import Display
from teleopctl.viewer.rviz_file import RvizFile, plain_class

# Any stands for what YAML holds.

# What RViz has where nobody has set anything, as far as that is neither zero nor empty nor false.
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
# What is done in another way, belongs to RViz's windows, or sets up MoveIt's own window.
_BESIDES = frozenset(
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
# More than these is no line that anybody reads.
_MOST = 12


def leftovers(file: RvizFile, path: Path, displays: Sequence[Display]) -> str:
    """Return a line about the parts of an ``.rviz`` file that are not shown; empty for none.

    Args:
        file: The file, as it was read.
        path: Its path, for the line.
        displays: Those that were made from it.
    """
    parts = [
        *_unknown_displays(file, displays),
        *(part for display in displays for part in _unknown_properties(file, display)),
        *_strange_classes("panel", file.document.get("Panels"), _PANELS),
        *_strange_classes("tool", file.tools(), _TOOLS),
        *_strange_view(file.current_view),
    ]
    if not parts:
        return ""
    more = f"; and {len(parts) - _MOST} more" if len(parts) > _MOST else ""
    return f"{path}: not shown, and kept when it is saved: {'; '.join(parts[:_MOST])}{more}"


def _unknown_displays(file: RvizFile, displays: Sequence[Display]) -> Iterator[str]:
    known = {id(display.values.given) for display in displays}
    first: dict[str, int | None] = {}
    for entry in file.displays():
        if id(entry.given) not in known:
            first.setdefault(entry.rviz_class, file.line_of(entry.given, "Class"))
    if first:
        named = ", ".join(f"{name}{_line(line)}" for name, line in first.items())
        yield f"displays of class {printable_line(named)}"


def _unknown_properties(file: RvizFile, display: Display) -> Iterator[str]:
    known = {property_.name for property_ in display.properties} | {display.topic_key}
    found = list(_asked_for(file, display.values.given, known, ""))
    if found:
        names = ", ".join(name for name, _ in found)
        yield printable_line(f"{names} of '{display.name}'{_line(found[0][1])}")


def _asked_for(
    file: RvizFile, given: dict[str, Any], known: set[str], above: str
) -> Iterator[tuple[str, int | None]]:
    """The properties that are not known and ask for something, each with its line."""
    for key, value in given.items():
        name = f"{above}{key}"
        if key in _BESIDES or name in known or str(key).startswith(_MOVEIT_WINDOW):
            continue
        if isinstance(value, dict) and any(one.startswith(f"{name}/") for one in known):
            yield from _asked_for(file, value, known, f"{name}/")
        elif _asks(str(key), value):
            yield name, file.line_of(given, key)


def _asks(key: str, value: Any) -> bool:
    """Whether a property has another value than RViz gives it."""
    if key == "Visibility":
        # A list of what RViz has seen, in which only what is switched off asks for something.
        return _has_false(value)
    if key in _DEFAULTS:
        return not _same(value, _DEFAULTS[key])
    if isinstance(value, dict):
        return any(_asks(str(inner), one) for inner, one in value.items())
    return bool(value)


def _has_false(value: Any) -> bool:
    if isinstance(value, dict):
        return any(_has_false(one) for one in value.values())
    return value is False


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, int | float) and isinstance(other, int | float):
        # RViz's numbers have 32 bits.
        return math.isclose(one, other, rel_tol=1e-6)
    return bool(one == other)


def _strange_classes(what: str, listed: Any, known: frozenset[str]) -> Iterator[str]:
    """The classes of a list that are not RViz's own."""
    entries: Iterable[Any] = listed if isinstance(listed, list) else ()
    names = [str(one.get("Class", "")) for one in entries if isinstance(one, dict)]
    strange = dict.fromkeys(name for name in names if name and not _is_rviz(name, known))
    if strange:
        many = "s" if len(strange) > 1 else ""
        yield printable_line(f"{what}{many} {', '.join(strange)}")


def _is_rviz(name: str, known: frozenset[str]) -> bool:
    return name.startswith(_RVIZ) and plain_class(name) in known


def _strange_view(current: dict[str, Any]) -> Iterator[str]:
    yield from _strange_classes("view controller", [current], _VIEWS)
    target = current.get("Target Frame")
    if isinstance(target, str) and target not in ("", "<Fixed Frame>"):
        yield printable_line(f"that the view follows '{target}'")


def _line(line: int | None) -> str:
    return "" if line is None else f" (line {line})"

"""Layouts of the page: positions of the panels beside the robot, read from YAML files.

A layout names panels by their names in the registry:

    version: 1
    title: Control
    bar: [simulation]           # in the bar below the robot, one below the other
    left:                       # a column at the left edge
      width: 240                # pixels
      panels: [[scene]]         # from top to bottom; panels of one list are tabs
    right: {width: 350, panels: [[joints, controllers], [camera], [plot, log]]}

The presets are files of the folder ``layouts`` of the package teleopctl. A saved layout also has
the robot's name, the camera and what was chosen in the panels.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from teleopctl import plugins
from teleopctl.base.files import read_text
from teleopctl.base.ros_yaml import faults_of, load
from teleopctl.errors import TeleopctlError, similar_names
from teleopctl.packages import package_share
from teleopctl.tf import Vector3
from teleopctl.viewer.rviz_file import View

VERSION = 1
"""Version of the layout files that this page reads and writes."""

OTHERS = "others"
"""Word in a layout for all panels of other packages."""

_LEAST_WIDTH_PX, _MOST_WIDTH_PX = 96, 2000
_USUAL_WIDTH_PX = 350
_MOST_STACKED = 8
_KEYS = {"version", "title", "bar", "left", "right", "robot", "view", "panels"}

# Any: YAML values.


class LayoutError(TeleopctlError):
    """Error: a layout cannot be read or names unknown panels; the text has the file."""


@dataclass(frozen=True)
class PanelColumn:
    """Column of panels at the left or right edge of the page.

    Attributes:
        stacks: Names of the panels, from top to bottom; panels of one stack are tabs.
        width_px: Width in pixels.
        is_minimized: Whether the column starts as a narrow strip.
    """

    stacks: tuple[tuple[str, ...], ...] = ()
    width_px: int = _USUAL_WIDTH_PX
    is_minimized: bool = False

    def names(self) -> list[str]:
        """Return the names of all panels of the column, in order."""
        return [name for stack in self.stacks for name in stack]

    def document(self) -> dict[str, Any]:
        """Return the column as YAML values."""
        minimized = {"minimized": True} if self.is_minimized else {}
        return {"width": self.width_px, **minimized, "panels": [list(one) for one in self.stacks]}


@dataclass(frozen=True)
class PageLayout:
    """Arrangement of the page's panels, and what was chosen in them.

    Attributes:
        title: Displayed name.
        left: Column at the left edge.
        right: Column at the right edge.
        bar: Names of the panels in the bar below the robot.
        robot: Name of the robot that a saved layout belongs to; empty for any.
        view: Camera of the 3D view; None for the usual one.
        states: Choices made in the panels, as YAML values, by name of the panel.
    """

    title: str = ""
    left: PanelColumn = field(default_factory=PanelColumn)
    right: PanelColumn = field(default_factory=PanelColumn)
    bar: tuple[str, ...] = ()
    robot: str = ""
    view: View | None = None
    states: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def with_panels(cls, names: Iterable[str]) -> PageLayout:
        """Return a layout with these panels as tabs of one column.

        Args:
            names: Names of the panels.
        """
        return cls(right=PanelColumn((tuple(names),)))

    def names(self) -> list[str]:
        """Return the names of all panels of the layout, in order."""
        return [*self.left.names(), *self.right.names(), *self.bar]

    def document(self) -> dict[str, Any]:
        """Return the layout as YAML values, to be read by `layout_of`."""
        document: dict[str, Any] = {"version": VERSION, "title": self.title}
        if self.robot:
            document["robot"] = self.robot
        document["bar"] = list(self.bar)
        for side, column in (("left", self.left), ("right", self.right)):
            if column.stacks:
                document[side] = column.document()
        if self.view is not None:
            document["view"] = {"eye": list(self.view.eye), "focus": list(self.view.focus)}
        if self.states:
            document["panels"] = dict(self.states)
        return document

    def text(self) -> str:
        """Return the layout as the text of a YAML file."""
        import yaml

        return yaml.safe_dump(self.document(), sort_keys=False, default_flow_style=None)

    def changed(self, shown: Iterable[str], hidden: Iterable[str]) -> PageLayout:
        """Return the layout with some panels added as tabs of the last stack, and some left out.

        Args:
            shown: Names of panels to add, unless the layout has them.
            hidden: Names of panels to leave out.
        """
        gone, there = frozenset(hidden), frozenset(self.names())
        more = tuple(name for name in shown if name not in there)
        right = list(self.right.stacks) or [()]
        right[-1] += more
        return replace(
            self,
            left=replace(self.left, stacks=_without(self.left.stacks, gone)),
            right=replace(self.right, stacks=_without(right, gone)),
            bar=tuple(name for name in self.bar if name not in gone),
        )


def _without(
    stacks: Iterable[tuple[str, ...]], gone: frozenset[str]
) -> tuple[tuple[str, ...], ...]:
    kept = (tuple(name for name in stack if name not in gone) for stack in stacks)
    return tuple(stack for stack in kept if stack)


def presets() -> list[str]:
    """Return the names of the layouts that come with the page, sorted."""
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def _folder() -> Path:
    return package_share("teleopctl") / "layouts"


def _others() -> list[str]:
    return [
        name for name in plugins.available(plugins.PANELS) if name not in plugins.PANELS.builtin
    ]


def load_layout(named: str | Path) -> PageLayout:
    """Return the layout of a preset's name or of a file.

    Args:
        named: Name of a preset, or path of a YAML file.

    Raises:
        TeleopctlError: There is no such layout, or the file is not one.
    """
    name = str(named)
    if name in presets():
        path = _folder() / f"{name}.yaml"
    else:
        path = Path(named)
        if not path.exists() and path.suffix not in (".yaml", ".yml"):
            near = similar_names(name, presets(), 1)
            guess = f" Did you mean {near[0]}?" if near else ""
            raise LayoutError(
                f"There is no layout {name}",
                hint=f"Layouts are {', '.join(presets())}, or a YAML file.{guess}",
            )
    text = read_text(path)
    with faults_of(path, LayoutError):
        document = load(text)
    return layout_of(document, str(path))


def layout_of(document: object, origin: str) -> PageLayout:
    """Return the layout that YAML values describe.

    Args:
        document: The YAML values.
        origin: Where the values come from, for error messages.

    Raises:
        LayoutError: The values are no layout of this version, or name unknown panels.
    """

    def fault(what: str, hint: str = "") -> LayoutError:
        return LayoutError(f"{origin}: {what}", hint=hint or None)

    if not isinstance(document, Mapping):
        raise fault("a layout is a mapping with 'version', 'left', 'right' and 'bar'")
    if document.get("version") != VERSION:
        raise fault(
            f"this is a layout of version {document.get('version')!r}; "
            f"this page reads version {VERSION}",
            "Arrange the panels again, and save the layout.",
        )
    unknown = [key for key in document if key not in _KEYS]
    if unknown:
        raise fault(f"a layout has no {unknown[0]!r}", f"Its keys are {', '.join(sorted(_KEYS))}.")
    seen: set[str] = set()

    def names_of(value: object, where: str) -> tuple[str, ...]:
        if not isinstance(value, Sequence) or isinstance(value, str):
            raise fault(f"{where} is {value!r}; it has to be a list of panels")
        names = [part for name in value for part in (_others() if name == OTHERS else [name])]
        for name in names:
            if not isinstance(name, str) or plugins.find(plugins.PANELS, name) is None:
                known = plugins.available(plugins.PANELS)
                raise fault(f"{where}: there is no panel {name!r}", f"Panels: {', '.join(known)}.")
            if name in seen:
                raise fault(f"{where}: the panel {name} stands there twice")
            seen.add(name)
        return tuple(names)

    def column_of(side: str) -> PanelColumn:
        value = document.get(side)
        if value is None:
            return PanelColumn()
        if not isinstance(value, Mapping) or value.keys() - {"width", "panels", "minimized"}:
            raise fault(f"{side!r} is a mapping with 'width', 'panels' and 'minimized'")
        width, stacks = value.get("width", _USUAL_WIDTH_PX), value.get("panels", [])
        minimized = value.get("minimized", False)
        if not isinstance(width, int) or not _LEAST_WIDTH_PX <= width <= _MOST_WIDTH_PX:
            raise fault(
                f"the width of {side!r} is {width!r}; it has to be a number from "
                f"{_LEAST_WIDTH_PX} to {_MOST_WIDTH_PX}"
            )
        if not isinstance(minimized, bool):
            raise fault(f"'minimized' of {side!r} is {minimized!r}, neither true nor false")
        if not isinstance(stacks, list) or len(stacks) > _MOST_STACKED:
            raise fault(f"'panels' of {side!r} is a list of at most {_MOST_STACKED} lists")
        return PanelColumn(
            tuple(names_of(one, f"'panels' of {side!r}") for one in stacks), width, minimized
        )

    states = document.get("panels", {})
    if not isinstance(states, Mapping):
        raise fault("'panels' is a mapping from panels to what was chosen in them")
    return PageLayout(
        title=str(document.get("title", "")),
        left=column_of("left"),
        right=column_of("right"),
        bar=names_of(document.get("bar", []), "'bar'"),
        robot=str(document.get("robot", "")),
        view=_view_of(document.get("view"), fault),
        states={str(name): state for name, state in states.items()},
    )


def _view_of(value: Any, fault: Any) -> View | None:
    if value is None:
        return None
    parts = [value.get(key) for key in ("eye", "focus")] if isinstance(value, Mapping) else []
    points = [point for point in map(_point_of, parts) if point is not None]
    if len(points) != 2:
        raise fault("'view' is a mapping with 'eye' and 'focus', each three numbers in metres")
    return View(*points)


def _point_of(value: object) -> Vector3 | None:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 3:
        return None
    if not all(isinstance(part, int | float) and math.isfinite(part) for part in value):
        return None
    x, y, z = map(float, value)
    return x, y, z

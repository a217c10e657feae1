"""``Grid``: lines on a plane of a frame, to see distances by."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from teleopctl.viewer.displays.base import Display
from teleopctl.viewer.displays.properties import Property

_PLANES: dict[str, Literal["xy", "xz", "yz"]] = {"XY": "xy", "XZ": "xz", "YZ": "yz"}
_FIXED_FRAME = "<Fixed Frame>"


class Grid(Display):
    """Display of a square grid around the origin of a frame."""

    rviz_class = "Grid"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Reference Frame", _FIXED_FRAME),
        Property("Plane", "XY", choices=("XY", "XZ", "YZ")),
        Property("Plane Cell Count", 10, low=1, high=1000),
        Property("Cell Size", 1.0, low=0.001, high=1000.0, hint="Metres"),
        Property("Color", (160, 160, 164)),
        Property("Alpha", 0.5, low=0.0, high=1.0),
    )

    def _prepare(self) -> None:
        self._node: Any = None

    def started(self) -> None:
        """Draw the grid's lines."""
        frame = self.values.text("Reference Frame")
        above = "" if frame == _FIXED_FRAME else self.stage.frames.node_of(frame)
        cell = self.values.number("Cell Size")
        size = cell * int(self.values.number("Plane Cell Count"))
        color = self.values.color("Color")
        self._node = self.stage.scene.add_grid(
            f"{above}{self.root}",
            size,
            size,
            plane=_PLANES[self.values.text("Plane")],
            cell_size=cell,
            section_size=cell,
            cell_color=color,
            section_color=color,
            fade_distance=max(100.0, 3 * size),
        )

    def stopped(self) -> None:
        """Remove the grid from the scene."""
        if self._node is not None:
            self._node.remove()
            self._node = None

    def time_jumped_back(self) -> None:
        """Do nothing: a grid has no time."""

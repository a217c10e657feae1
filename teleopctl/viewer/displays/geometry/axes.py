"""``Axes``: the axes of one frame, large."""

from __future__ import annotations

from typing import ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing

# Any stands for messages throughout: their classes are made at run time, from definitions.

_FIXED_FRAME = "<Fixed Frame>"


class Axes(Display):
    """Display of a frame's axes: x red, y green, z blue."""

    rviz_class = "Axes"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Reference Frame", _FIXED_FRAME, is_frame=True),
        Property("Length", 1.0, low=0.001, high=1000.0),
        Property("Radius", 0.1, low=0.001, high=1000.0),
        Property("Alpha", 1.0, low=0.0, high=1.0),
    )

    def _prepare(self) -> None:
        self._canvas: Canvas | None = None

    def started(self) -> None:
        """Draw the axes below their frame's node."""
        frame = self.values.text("Reference Frame")
        above = "" if frame == _FIXED_FRAME else self.stage.frames.node_of(frame)
        drawing = Drawing()
        length, radius = self.values.number("Length"), self.values.number("Radius")
        drawing.axes(Transform(), length, radius, self.values.number("Alpha"))
        self._canvas = Canvas(self.stage.scene, f"{above}{self.root}")
        self._canvas.show(drawing)

    def tick(self) -> None:
        """Set the status by whether the reference frame is known."""
        name = self.values.text("Reference Frame").removeprefix("/")
        frame = self.stage.frames.by_name.get(name)
        known = name == _FIXED_FRAME or (frame is not None and frame.pose is not None)
        fixed = self.stage.frames.fixed
        self.say(OK) if known else self.say(WARN, f"No transform from [{name}] to [{fixed}]")

    def stopped(self) -> None:
        """Remove the axes from the scene."""
        if self._canvas is not None:
            self._canvas.remove()
            self._canvas = None

    def time_jumped_back(self) -> None:
        """Do nothing: tf moves the frame."""

"""``Polygon`` and ``GridCells``: an outline, and squares on a plane."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, WARN
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import left_out_text, points_of, rgba_of
from teleopctl.viewer.scene.drawing import HAIR, Drawing, is_drawable

# Any stands for messages throughout: their classes are made at run time, from definitions.

_GREEN = (25, 255, 0)
# Cells are squares; this much of a height lets them be seen from the side.
_THIN_M = 0.001


class Polygon(DrawnDisplay):
    """Display of a polygon's outline, such as a robot's footprint."""

    rviz_class = "Polygon"
    message_type = "geometry_msgs/msg/PolygonStamped"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", _GREEN),
        Property("Alpha", 1.0, low=0.0, high=1.0, hint="0 hides it"),
    )

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a polygon: a closed line."""
        drawing = Drawing()
        points, left_out = points_of(message.polygon.points)
        if left_out:
            self.say(WARN, left_out_text(left_out, "corners"))
        if len(points) and self.values.number("Alpha") > 0:
            closed = np.vstack([points, points[:1]])
            color = np.array(rgba_of(self.values.color("Color")))
            drawing.line(closed, color, HAIR, strip=True)
        return drawing


class GridCells(DrawnDisplay):
    """Display of grid cells: squares of one size."""

    rviz_class = "GridCells"
    message_type = "nav_msgs/msg/GridCells"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", _GREEN),
        Property("Alpha", 1.0, low=0.0, high=1.0),
    )

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of grid cells: a flat square at each point."""
        drawing = Drawing()
        width, height = message.cell_width, message.cell_height
        if not is_drawable((width, height)) or width <= 0 or height <= 0:
            self.say(ERROR, f"The cells are not drawn: they are {width} by {height} m")
            return drawing
        points, left_out = points_of(message.cells)
        if left_out:
            self.say(WARN, left_out_text(left_out, "cells"))
        color = np.array(rgba_of(self.values.color("Color"), self.values.number("Alpha")))
        drawing.solids_at("box", points, Transform(), (width, height, _THIN_M), color)
        return drawing

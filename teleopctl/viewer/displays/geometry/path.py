"""``PathDisplay``: the poses that something will pass, or has passed, joined by a line."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import WARN
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import left_out_text, poses_of, rgba_of
from teleopctl.viewer.scene.drawing import HAIR, ArrowSize, Drawing

# Any stands for messages throughout: their classes are made at run time, from definitions.


class PathDisplay(DrawnDisplay):
    """Display of a path: a line, and optionally shapes at its poses."""

    rviz_class = "Path"
    message_type = "nav_msgs/msg/Path"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", (25, 255, 0)),
        Property("Alpha", 1.0, low=0.0, high=1.0, hint="0 hides the line"),
        Property("Line Style", "Lines", choices=("Lines", "Billboards")),
        Property("Line Width", 0.03, low=0.001, high=100.0, hint="Metres, of billboards"),
        Property("Buffer Length", 1, low=1, high=1000, hint="How many paths are drawn"),
        Property("Pose Style", "None", choices=("None", "Axes", "Arrows")),
        Property("Pose Color", (255, 85, 255)),
        Property("Length", 0.3, low=0.0, high=1000.0, hint="Of axes"),
        Property("Radius", 0.03, low=0.0, high=1000.0, hint="Of axes"),
        Property("Shaft Length", 0.1, low=0.0, high=1000.0),
        Property("Shaft Diameter", 0.1, low=0.0, high=1000.0),
        Property("Head Length", 0.2, low=0.0, high=1000.0),
        Property("Head Diameter", 0.3, low=0.0, high=1000.0),
    )

    @property
    def keeps(self) -> int:
        """Number of paths that are drawn."""
        return int(self.values.number("Buffer Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a path: its line, and the shapes of its poses."""
        values = self.values
        positions, rotations, left_out = poses_of(one.pose for one in message.poses)
        if left_out:
            self.say(WARN, left_out_text(left_out, "poses"))
        drawing = self._pose_shape().copies(positions, rotations)
        if values.number("Alpha") > 0:
            is_wide = values.text("Line Style") == "Billboards"
            width = values.number("Line Width") if is_wide else HAIR
            drawing.line(positions, np.array(rgba_of(values.color("Color"))), width, strip=True)
        return drawing

    def _pose_shape(self) -> Drawing:
        values, drawing = self.values, Drawing()
        style = values.text("Pose Style")
        if style == "Axes":
            drawing.axes(Transform(), values.number("Length"), values.number("Radius"))
        elif style == "Arrows":
            size = ArrowSize(
                values.number("Shaft Length"),
                values.number("Shaft Diameter"),
                values.number("Head Length"),
                values.number("Head Diameter"),
            )
            drawing.arrow(Transform(), size, rgba_of(values.color("Pose Color")))
        return drawing

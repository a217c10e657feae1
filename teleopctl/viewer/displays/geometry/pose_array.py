"""``PoseArray``: many poses, such as the particles of a localization."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import WARN
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import left_out_text, poses_of, rgba_of
from teleopctl.viewer.scene.drawing import HAIR, ArrowSize, Drawing, Rgba

# Any stands for messages throughout: their classes are made at run time, from definitions.


class PoseArray(DrawnDisplay):
    """Display of an array of poses."""

    rviz_class = "PoseArray"
    message_type = "geometry_msgs/msg/PoseArray"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Shape", "Arrow (Flat)", choices=("Arrow (Flat)", "Arrow (3D)", "Axes")),
        Property("Color", (255, 25, 0)),
        Property("Alpha", 1.0, low=0.0, high=1.0),
        Property("Arrow Length", 0.3, low=0.0, high=1000.0, hint="Of flat arrows"),
        Property("Shaft Length", 0.23, low=0.0, high=1000.0),
        Property("Shaft Radius", 0.01, low=0.0, high=1000.0),
        Property("Head Length", 0.07, low=0.0, high=1000.0),
        Property("Head Radius", 0.03, low=0.0, high=1000.0),
        Property("Axes Length", 0.3, low=0.0, high=1000.0),
        Property("Axes Radius", 0.01, low=0.0, high=1000.0),
    )

    def drawing(self, message: Any) -> Drawing:
        """Return a drawing with a shape at each pose."""
        positions, rotations, left_out = poses_of(message.poses)
        if left_out:
            self.say(WARN, left_out_text(left_out, "poses"))
        return self._shape().copies(positions, rotations)

    def _shape(self) -> Drawing:
        values, drawing = self.values, Drawing()
        alpha = values.number("Alpha")
        color = rgba_of(values.color("Color"), alpha)
        shape = values.text("Shape")
        if shape == "Axes":
            length, radius = values.number("Axes Length"), values.number("Axes Radius")
            drawing.axes(Transform(), length, radius, alpha)
        elif shape == "Arrow (3D)":
            size = ArrowSize(
                values.number("Shaft Length"),
                2 * values.number("Shaft Radius"),
                values.number("Head Length"),
                2 * values.number("Head Radius"),
            )
            drawing.arrow(Transform(), size, color)
        elif alpha > 0:
            flat_arrow(drawing, values.number("Arrow Length"), color)
        return drawing


def flat_arrow(drawing: Drawing, length: float, color: Rgba) -> None:
    """Add a flat arrow of three lines along x, as RViz draws pose arrays."""
    tip, left, right = (1.0, 0.0, 0.0), (0.75, 0.2, 0.0), (0.75, -0.2, 0.0)
    ends = length * np.array([(0.0, 0.0, 0.0), tip, tip, left, tip, right])
    drawing.line(ends, np.array(color), HAIR, strip=False)

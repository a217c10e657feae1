"""``PointStamped``: the last points, as balls."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import rgba_of, vector_of
from teleopctl.viewer.scene.drawing import Drawing, is_drawable

# Any stands for messages throughout: their classes are made at run time, from definitions.


class PointStamped(DrawnDisplay):
    """Display of a stamped point and the ones received before."""

    rviz_class = "PointStamped"
    message_type = "geometry_msgs/msg/PointStamped"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", (204, 41, 204)),
        Property("Alpha", 1.0, low=0.0, high=1.0),
        Property("Radius", 0.2, low=0.001, high=1000.0),
        Property("History Length", 1, low=1, high=10_000, hint="How many points are drawn"),
    )

    @property
    def keeps(self) -> int:
        """Number of points that are drawn."""
        return int(self.values.number("History Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a point: a sphere."""
        drawing = Drawing()
        place = vector_of(message.point)
        if not is_drawable(place):
            self.say(ERROR, "The point is not drawn: its numbers must be finite")
            return drawing
        size = 2 * self.values.number("Radius")
        color = rgba_of(self.values.color("Color"), self.values.number("Alpha"))
        drawing.solid("sphere", Transform(place), (size, size, size), color)
        return drawing

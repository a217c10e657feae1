"""``Range``: what an ultrasonic or infrared sensor measures, as a cone."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, WARN
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import rgba_of
from teleopctl.viewer.scene.drawing import Drawing, is_drawable

# Any stands for messages throughout: their classes are made at run time, from definitions.

# A cone that opens wider than this has no base that could be drawn.
_WIDEST_RAD = 3.0
_TIP_BACK = (0.0, -math.sqrt(0.5), 0.0, math.sqrt(0.5))


class Range(DrawnDisplay):
    """Display of a range: a cone along the sensor's x axis."""

    rviz_class = "Range"
    message_type = "sensor_msgs/msg/Range"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", (255, 255, 255)),
        Property("Alpha", 0.5, low=0.0, high=1.0),
        Property("Buffer Length", 1, low=1, high=1000, hint="How many cones are drawn"),
    )

    @property
    def keeps(self) -> int:
        """Number of cones that are drawn."""
        return int(self.values.number("Buffer Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a range: a cone."""
        drawing = Drawing()
        if not is_drawable((message.field_of_view, message.min_range, message.max_range)):
            self.say(ERROR, "The cone is not drawn: its numbers must be finite")
            return drawing
        distance = _distance(message)
        if distance is None:
            self.say(
                WARN,
                f"Nothing between {message.min_range:.3g} and {message.max_range:.3g} m: "
                f"the sensor says {message.range:.3g} m",
            )
            return drawing
        across = 2 * distance * math.tan(min(abs(message.field_of_view), _WIDEST_RAD) / 2)
        color = rgba_of(self.values.color("Color"), self.values.number("Alpha"))
        # The tip is at the sensor, the base where the echo came from.
        place = Transform((distance / 2, 0.0, 0.0), _TIP_BACK)
        drawing.solid("cone", place, (across, across, distance), color)
        return drawing


def _distance(message: Any) -> float | None:
    """How far the sensor sees; None for nothing in its range.

    REP 117: a sensor of one fixed distance says -inf for something nearer and inf for nothing.
    """
    if message.min_range == message.max_range and message.range < 0 and message.min_range > 0:
        return float(message.min_range)
    if message.min_range <= message.range <= message.max_range and message.range > 0:
        return float(message.range)
    return None

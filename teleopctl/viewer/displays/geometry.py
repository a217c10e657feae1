"""Displays of points, polygons, grid cells, ranges, wrenches, twists and accelerations."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, WARN
from teleopctl.viewer.displays.conversions import (
    length_of,
    not_drawn_text,
    points_of,
    rgba_of,
    vector_of,
)
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.stamped import DrawnDisplay
from teleopctl.viewer.scene.drawing import (
    HAIR,
    ArrowSize,
    Drawing,
    Rgba,
    is_drawable,
    pose_along,
)

# Any: messages, whose classes are created from definitions at run time.


class PointStamped(DrawnDisplay):
    """RViz's ``PointStamped`` display: the last points, as spheres."""

    rviz_class = "PointStamped"
    message_type = "geometry_msgs/msg/PointStamped"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", (204, 41, 204)),
        Property("Alpha", 1.0, low=0.0, high=1.0),
        Property("Radius", 0.2, low=0.001, high=1000.0),
        Property("History Length", 1, low=1, high=10_000, hint="Number of points to keep"),
    )

    @property
    def history_length(self) -> int:
        """Largest number of points drawn at a time: the property ``History Length``."""
        return int(self.values.number("History Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a PointStamped: a sphere; empty if its numbers are not finite."""
        drawing = Drawing()
        place = vector_of(message.point)
        if not is_drawable(place):
            self.set_status(ERROR, "The point is not drawn: its numbers must be finite")
            return drawing
        size = 2 * self.values.number("Radius")
        color = rgba_of(self.values.color("Color"), self.values.number("Alpha"))
        drawing.solid("sphere", Transform(place), (size, size, size), color)
        return drawing


_GREEN = (25, 255, 0)
# Height of a cell, so that flat cells are visible from the side.
_THIN_M = 0.001


class Polygon(DrawnDisplay):
    """RViz's ``Polygon`` display: the outline of a polygon, such as a robot's footprint."""

    rviz_class = "Polygon"
    message_type = "geometry_msgs/msg/PolygonStamped"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", _GREEN),
        Property("Alpha", 1.0, low=0.0, high=1.0, hint="0 hides it"),
    )

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a PolygonStamped: a closed line."""
        drawing = Drawing()
        points, left_out = points_of(message.polygon.points)
        if left_out:
            self.set_status(WARN, not_drawn_text(left_out, "corners"))
        if len(points) and self.values.number("Alpha") > 0:
            closed = np.vstack([points, points[:1]])
            color = np.array(rgba_of(self.values.color("Color")))
            drawing.line(closed, color, HAIR, strip=True)
        return drawing


class GridCells(DrawnDisplay):
    """RViz's ``GridCells`` display: flat rectangles of one size."""

    rviz_class = "GridCells"
    message_type = "nav_msgs/msg/GridCells"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", _GREEN),
        Property("Alpha", 1.0, low=0.0, high=1.0),
    )

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a GridCells message: a flat rectangle at each point."""
        drawing = Drawing()
        width, height = message.cell_width, message.cell_height
        if not is_drawable((width, height)) or width <= 0 or height <= 0:
            self.set_status(ERROR, f"The cells are not drawn: they are {width} by {height} m")
            return drawing
        points, left_out = points_of(message.cells)
        if left_out:
            self.set_status(WARN, not_drawn_text(left_out, "cells"))
        color = np.array(rgba_of(self.values.color("Color"), self.values.number("Alpha")))
        drawing.solids_at("box", points, Transform(), (width, height, _THIN_M), color)
        return drawing


# Largest opening angle drawn: the base of a wider cone becomes too large.
_WIDEST_RAD = 3.0
_TIP_BACK = (0.0, -math.sqrt(0.5), 0.0, math.sqrt(0.5))


class Range(DrawnDisplay):
    """RViz's ``Range`` display: a cone along the sensor's x axis, as long as the measured range."""

    rviz_class = "Range"
    message_type = "sensor_msgs/msg/Range"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", (255, 255, 255)),
        Property("Alpha", 0.5, low=0.0, high=1.0),
        Property("Buffer Length", 1, low=1, high=1000, hint="Number of cones to keep"),
    )

    @property
    def history_length(self) -> int:
        """Largest number of cones drawn at a time: the property ``Buffer Length``."""
        return int(self.values.number("Buffer Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a Range: a cone as long as the distance; empty if out of range."""
        drawing = Drawing()
        if not is_drawable((message.field_of_view, message.min_range, message.max_range)):
            self.set_status(ERROR, "The cone is not drawn: its numbers must be finite")
            return drawing
        distance = _distance(message)
        if distance is None:
            self.set_status(
                WARN,
                f"Nothing between {message.min_range:.3g} and {message.max_range:.3g} m: "
                f"the sensor measures {message.range:.3g} m",
            )
            return drawing
        across = 2 * distance * math.tan(min(abs(message.field_of_view), _WIDEST_RAD) / 2)
        color = rgba_of(self.values.color("Color"), self.values.number("Alpha"))
        # The tip is at the sensor, the base at the measured distance.
        place = Transform((distance / 2, 0.0, 0.0), _TIP_BACK)
        drawing.solid("cone", place, (across, across, distance), color)
        return drawing


def _distance(message: Any) -> float | None:
    """Return the distance to the measured object in metres; None for no object in range.

    REP 117: a fixed-distance ranger reports -inf for a detection and inf for no detection.
    """
    if message.min_range == message.max_range and message.range < 0 and message.min_range > 0:
        return float(message.min_range)
    if message.min_range <= message.range <= message.max_range and message.range > 0:
        return float(message.range)
    return None


_CIRCLE_PARTS = 24


def _properties(along_name: str, about_name: str, scale: float) -> tuple[Property, ...]:
    return (
        Property(f"{along_name} Color", (204, 51, 51)),
        Property(f"{about_name} Color", (204, 204, 51)),
        Property("Alpha", 1.0, low=0.0, high=1.0),
        Property(f"{along_name} Arrow Scale", scale, low=0.0, high=1000.0, hint="Metres per unit"),
        Property(f"{about_name} Arrow Scale", scale, low=0.0, high=1000.0, hint="Metres per unit"),
        Property("Arrow Width", 0.5, low=0.0, high=1000.0),
        Property("History Length", 1, low=1, high=1000, hint="Number of messages to keep"),
        Property("Hide Small Values", True, hint="Hide arrows that are shorter than they are wide"),
    )


class VectorPairDisplay(DrawnDisplay):
    """Base of RViz's ``Wrench``, ``TwistStamped`` and ``AccelStamped``: two arrows at a frame.

    The first arrow is along the linear vector (force, velocity, acceleration), the second along
    the angular one, with an arc around it.

    Attributes:
        part: Field of the message that holds the two vectors.
        along_name: Name of the linear vector in properties; in lower case, of its message field.
        about_name: Name of the angular vector in properties; in lower case, of its message field.
    """

    part: ClassVar[str]
    along_name: ClassVar[str]
    about_name: ClassVar[str]

    @property
    def history_length(self) -> int:
        """Largest number of messages drawn at a time: the property ``History Length``."""
        return int(self.values.number("History Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a message: arrows for its two vectors, very short ones hidden."""
        drawing = Drawing()
        names = (self.along_name, self.about_name)
        part = getattr(message, self.part)
        vectors = [vector_of(getattr(part, name.lower())) for name in names]
        if not is_drawable((*vectors[0], *vectors[1])):
            self.set_status(ERROR, "Nothing is drawn: the numbers must be finite")
            return drawing
        for name, vector in zip(names, vectors, strict=True):
            alpha = self.values.number("Alpha")
            color = rgba_of(self.values.color(f"{name} Color"), alpha)
            length = length_of(*vector) * self.values.number(f"{name} Arrow Scale")
            width = self.values.number("Arrow Width")
            if alpha > 0 and length > (width if self.values.flag("Hide Small Values") else 0.0):
                pose, _ = pose_along((0.0, 0.0, 0.0), vector)
                _draw_arrow(drawing, pose, length, width, color)
                if name == self.about_name:
                    _draw_arc(drawing, pose, length, color)
        return drawing


def _draw_arrow(
    drawing: Drawing, pose: Transform, length: float, width: float, color: Rgba
) -> None:
    # RViz's proportions: a head of 0.3 on a shaft of 1.
    head = length * 0.3 / 1.3
    drawing.arrow(pose, ArrowSize(length - head, 0.1 * width, head, 0.2 * width), color)


def _draw_arc(drawing: Drawing, pose: Transform, length: float, color: Rgba) -> None:
    """Add an arc of 270 degrees with a barb around the middle of an angular vector's arrow."""
    radius = length / 4
    angles = np.linspace(0.0, 1.5 * math.pi, _CIRCLE_PARTS)
    middle = np.full_like(angles, length / 2)
    circle = np.stack([middle, radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    end = circle[-1]
    barbs = [end + radius * np.array([side, -0.25, 0.0]) for side in (0.15, -0.15)]
    turn = Drawing()
    shade = np.array(color)
    turn.line(circle, shade, HAIR, strip=True)
    turn.line(np.array([barbs[0], end, barbs[1]]), shade, HAIR, strip=True)
    for width, rows in turn.moved(pose).lines.items():
        drawing.lines.setdefault(width, rows.__class__()).add(rows)


class Wrench(VectorPairDisplay):
    """RViz's ``Wrench`` display: force (N) and torque (N m) of a WrenchStamped, as arrows."""

    rviz_class = "Wrench"
    message_type = "geometry_msgs/msg/WrenchStamped"
    part, along_name, about_name = "wrench", "Force", "Torque"
    properties: ClassVar[tuple[Property, ...]] = _properties("Force", "Torque", 2.0)


class TwistStamped(VectorPairDisplay):
    """RViz's ``TwistStamped`` display: linear (m/s) and angular velocity (rad/s), as arrows."""

    rviz_class = "TwistStamped"
    message_type = "geometry_msgs/msg/TwistStamped"
    part, along_name, about_name = "twist", "Linear", "Angular"
    properties: ClassVar[tuple[Property, ...]] = _properties("Linear", "Angular", 1.0)


class AccelStamped(VectorPairDisplay):
    """RViz's ``AccelStamped`` display: linear (m/s²) and angular (rad/s²) acceleration arrows."""

    rviz_class = "AccelStamped"
    message_type = "geometry_msgs/msg/AccelStamped"
    part, along_name, about_name = "accel", "Linear", "Angular"
    properties: ClassVar[tuple[Property, ...]] = _properties("Linear", "Angular", 2.0)

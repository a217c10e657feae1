"""``Wrench``, ``TwistStamped`` and ``AccelStamped``: an arrow along, and one to turn about."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import length_of, rgba_of, vector_of
from teleopctl.viewer.scene.drawing import (
    HAIR,
    ArrowSize,
    Drawing,
    Rgba,
    Vector,
    along,
    is_drawable,
)

# Any stands for messages throughout: their classes are made at run time, from definitions.

_CIRCLE_PARTS = 24


def _properties(along_name: str, about_name: str, scale: float) -> tuple[Property, ...]:
    return (
        Property(f"{along_name} Color", (204, 51, 51)),
        Property(f"{about_name} Color", (204, 204, 51)),
        Property("Alpha", 1.0, low=0.0, high=1.0),
        Property(f"{along_name} Arrow Scale", scale, low=0.0, high=1000.0, hint="Metres per unit"),
        Property(f"{about_name} Arrow Scale", scale, low=0.0, high=1000.0, hint="Metres per unit"),
        Property("Arrow Width", 0.5, low=0.0, high=1000.0),
        Property("History Length", 1, low=1, high=1000, hint="How many are drawn"),
        Property("Hide Small Values", True, hint="Hide arrows that are shorter than they are wide"),
    )


class ScrewDisplay(DrawnDisplay):
    """Base of the twist and wrench displays: a linear and an angular vector at a frame's origin.

    Attributes:
        along_name: What the first is called in properties.
        about_name: What the second is called.
    """

    along_name: ClassVar[str]
    about_name: ClassVar[str]

    def vectors(self, message: Any) -> tuple[Vector, Vector]:
        """Return the linear and the angular vector of a message."""
        raise NotImplementedError

    @property
    def keeps(self) -> int:
        """Number of messages that are drawn."""
        return int(self.values.number("History Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of the two vectors: arrows."""
        drawing = Drawing()
        vectors = self.vectors(message)
        if not is_drawable((*vectors[0], *vectors[1])):
            self.say(ERROR, "Nothing is drawn: the numbers must be finite")
            return drawing
        for name, vector in zip((self.along_name, self.about_name), vectors, strict=True):
            alpha = self.values.number("Alpha")
            color = rgba_of(self.values.color(f"{name} Color"), alpha)
            length = length_of(*vector) * self.values.number(f"{name} Arrow Scale")
            width = self.values.number("Arrow Width")
            if alpha > 0 and length > (width if self.values.flag("Hide Small Values") else 0.0):
                pose, _ = along((0.0, 0.0, 0.0), vector)
                _draw_arrow(drawing, pose, length, width, color)
                if name == self.about_name:
                    _draw_turn(drawing, pose, length, color)
        return drawing


def _draw_arrow(
    drawing: Drawing, pose: Transform, length: float, width: float, color: Rgba
) -> None:
    # RViz's proportions: a head of 0.3 behind a shaft of 1.
    head = length * 0.3 / 1.3
    drawing.arrow(pose, ArrowSize(length - head, 0.1 * width, head, 0.2 * width), color)


def _draw_turn(drawing: Drawing, pose: Transform, length: float, color: Rgba) -> None:
    """Three quarters of a circle around the arrow's middle, with a barb at its end."""
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


class Wrench(ScrewDisplay):
    """Display of a wrench: force and torque."""

    rviz_class = "Wrench"
    message_type = "geometry_msgs/msg/WrenchStamped"
    along_name, about_name = "Force", "Torque"
    properties: ClassVar[tuple[Property, ...]] = _properties("Force", "Torque", 2.0)

    def vectors(self, message: Any) -> tuple[Vector, Vector]:
        """Return force (N) and torque (N m)."""
        return vector_of(message.wrench.force), vector_of(message.wrench.torque)


class TwistStamped(ScrewDisplay):
    """Display of a twist: linear and angular velocity."""

    rviz_class = "TwistStamped"
    message_type = "geometry_msgs/msg/TwistStamped"
    along_name, about_name = "Linear", "Angular"
    properties: ClassVar[tuple[Property, ...]] = _properties("Linear", "Angular", 1.0)

    def vectors(self, message: Any) -> tuple[Vector, Vector]:
        """Return linear (m/s) and angular velocity (rad/s)."""
        return vector_of(message.twist.linear), vector_of(message.twist.angular)


class AccelStamped(ScrewDisplay):
    """Display of an acceleration, linear and angular."""

    rviz_class = "AccelStamped"
    message_type = "geometry_msgs/msg/AccelStamped"
    along_name, about_name = "Linear", "Angular"
    properties: ClassVar[tuple[Property, ...]] = _properties("Linear", "Angular", 2.0)

    def vectors(self, message: Any) -> tuple[Vector, Vector]:
        """Return linear (m/s²) and angular acceleration (rad/s²)."""
        return vector_of(message.accel.linear), vector_of(message.accel.angular)

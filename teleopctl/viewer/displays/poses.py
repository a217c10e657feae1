"""Displays of poses, alone, in arrays, with covariance, of odometry, particles and paths."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, WARN
from teleopctl.viewer.displays.conversions import (
    length_of,
    not_drawn_text,
    pose_of,
    poses_of,
    rgba_of,
)
from teleopctl.viewer.displays.covariance import COVARIANCE_PROPERTIES, draw_covariance
from teleopctl.viewer.displays.properties import Properties, Property
from teleopctl.viewer.displays.stamped import DrawnDisplay
from teleopctl.viewer.scene.drawing import HAIR, ArrowSize, Drawing, Rgba, is_drawable, merged

_MOST_M = 1000.0


def shape_properties(parent_property: str = "") -> tuple[Property, ...]:
    """Return `Property` definitions for a pose drawn as arrow or axes: shape, colour and sizes.

    Args:
        parent_property: Name of the property that contains them; empty for the display's top level.
    """
    above = f"{parent_property}/" if parent_property else ""
    return (
        Property(parent_property or "Shape", "Arrow", choices=("Arrow", "Axes")),
        Property(f"{above}Color", (255, 25, 0)),
        Property(f"{above}Alpha", 1.0, low=0.0, high=1.0),
        Property(f"{above}Shaft Length", 1.0, low=0.0, high=_MOST_M),
        Property(f"{above}Shaft Radius", 0.05, low=0.0, high=_MOST_M),
        Property(f"{above}Head Length", 0.3, low=0.0, high=_MOST_M),
        Property(f"{above}Head Radius", 0.1, low=0.0, high=_MOST_M),
        Property(f"{above}Axes Length", 1.0, low=0.0, high=_MOST_M),
        Property(f"{above}Axes Radius", 0.1, low=0.0, high=_MOST_M),
    )


def draw_pose(
    drawing: Drawing, pose: Transform, properties: Properties, parent_property: str = ""
) -> None:
    """Add an arrow or axes at a pose to a drawing, by the values of `shape_properties`."""
    above = f"{parent_property}/" if parent_property else ""
    alpha = properties.number(f"{above}Alpha")
    if properties.text(parent_property or "Shape") == "Axes":
        length = properties.number(f"{above}Axes Length")
        drawing.axes(pose, length, properties.number(f"{above}Axes Radius"), alpha)
        return
    size = ArrowSize(
        properties.number(f"{above}Shaft Length"),
        2 * properties.number(f"{above}Shaft Radius"),
        properties.number(f"{above}Head Length"),
        2 * properties.number(f"{above}Head Radius"),
    )
    drawing.arrow(pose, size, rgba_of(properties.color(f"{above}Color"), alpha))


# Any: messages, whose classes are created from definitions at run time.

NOT_FINITE = "The pose is not drawn: its numbers must be finite"


class PoseDisplay(DrawnDisplay):
    """RViz's ``Pose`` display: the newest pose, as an arrow or axes."""

    rviz_class = "Pose"
    message_type = "geometry_msgs/msg/PoseStamped"
    properties: ClassVar[tuple[Property, ...]] = shape_properties()

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a PoseStamped: an arrow or axes; empty if not finite."""
        drawing = Drawing()
        pose = pose_of(message.pose)
        if pose is None:
            self.set_status(ERROR, NOT_FINITE)
        else:
            draw_pose(drawing, pose, self.values)
        return drawing


class PoseWithCovariance(DrawnDisplay):
    """RViz's ``PoseWithCovariance`` display: the newest pose with its covariance."""

    rviz_class = "PoseWithCovariance"
    message_type = "geometry_msgs/msg/PoseWithCovarianceStamped"
    properties: ClassVar[tuple[Property, ...]] = (*shape_properties(), *COVARIANCE_PROPERTIES)

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a pose's arrow or axes and covariance; empty if not finite."""
        drawing = Drawing()
        pose = pose_of(message.pose.pose)
        if pose is None:
            self.set_status(ERROR, NOT_FINITE)
            return drawing
        draw_pose(drawing, pose, self.values)
        fault = draw_covariance(drawing, pose, list(message.pose.covariance), self.values)
        if fault:
            self.set_status(WARN, fault)
        return drawing


# With ``Keep`` 0 RViz keeps all poses; this limit keeps memory from growing over days.
_MOST_KEPT = 10_000


class OdometryDisplay(DrawnDisplay):
    """RViz's ``Odometry`` display: the last poses, with the covariance of the newest."""

    rviz_class = "Odometry"
    message_type = "nav_msgs/msg/Odometry"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Position Tolerance", 0.1, low=0.0, high=1000.0, hint="Metres to the next shape"),
        Property("Angle Tolerance", 0.1, low=0.0, high=10.0, hint="Radians to the next shape"),
        Property("Keep", 100, low=0, high=_MOST_KEPT, hint="Number of poses to keep"),
        *shape_properties("Shape"),
        *COVARIANCE_PROPERTIES,
    )

    def _prepare(self) -> None:
        super()._prepare()
        self._last: Transform | None = None
        self._covariance = Drawing()

    @property
    def history_length(self) -> int:
        """Largest number of poses drawn: the property ``Keep``, or 10,000 if that is 0."""
        return int(self.values.number("Keep")) or _MOST_KEPT

    def received(self, message: Any) -> None:
        """Draw an Odometry's pose if it differs from the last by more than the tolerances."""
        pose = pose_of(message.pose.pose)
        if pose is None:
            self.set_status(ERROR, NOT_FINITE)
        elif self._last is None or self._differs(self._last, pose):
            self._last = pose
            super().received(message)

    def stopped(self) -> None:
        """Remove the poses, and drop all messages; called when the display stops."""
        self._last = None
        super().stopped()

    def draw_at(self, message: Any, pose: Transform) -> None:
        """Add a message's pose to the drawn ones, and replace the drawn covariance."""
        self._covariance = Drawing()
        super().draw_at(message, pose)
        self._covariance = self._covariance.moved(pose)

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of an Odometry's pose; store the drawing of its covariance."""
        drawing = Drawing()
        pose = pose_of(message.pose.pose)
        if pose is not None:
            draw_pose(drawing, pose, self.values, "Shape")
            numbers = list(message.pose.covariance)
            fault = draw_covariance(self._covariance, pose, numbers, self.values)
            if fault:
                self.set_status(WARN, fault)
        return drawing

    def combined_drawing(self) -> Drawing:
        """Return one drawing of all kept poses and of the newest pose's covariance."""
        return merged([super().combined_drawing(), self._covariance])

    def clear_drawings(self) -> None:
        """Clear the drawings of poses and covariance."""
        self._covariance = Drawing()
        super().clear_drawings()

    def _differs(self, last: Transform, pose: Transform) -> bool:
        step = (last.inverse() @ pose).translation
        if length_of(*step) > self.values.number("Position Tolerance"):
            return True
        cosine = abs(sum(a * b for a, b in zip(last.rotation, pose.rotation, strict=True)))
        return 2 * math.acos(min(cosine, 1.0)) > self.values.number("Angle Tolerance")


class PoseArray(DrawnDisplay):
    """RViz's ``PoseArray`` display: an arrow or axes at each pose."""

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
        """Return the drawing of a PoseArray: an arrow or axes at each pose."""
        positions, rotations, left_out = poses_of(message.poses)
        if left_out:
            self.set_status(WARN, not_drawn_text(left_out, "poses"))
        return self._shape().copied_to(positions, rotations)

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
            add_flat_arrow(drawing, values.number("Arrow Length"), color)
        return drawing


def add_flat_arrow(drawing: Drawing, length: float, color: Rgba) -> None:
    """Add an arrow of three lines along the x axis to a drawing, as RViz draws pose arrays."""
    tip, left, right = (1.0, 0.0, 0.0), (0.75, 0.2, 0.0), (0.75, -0.2, 0.0)
    ends = length * np.array([(0.0, 0.0, 0.0), tip, tip, left, tip, right])
    drawing.line(ends, np.array(color), HAIR, strip=False)


# Number of steps from the shortest to the longest arrow.
_LENGTHS = 20


class ParticleCloud(DrawnDisplay):
    """Navigation2's ``ParticleCloud`` display: localization particles, likelier ones longer."""

    rviz_class = "ParticleCloud"
    message_type = "nav2_msgs/msg/ParticleCloud"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Shape", "Arrow (Flat)", choices=("Arrow (Flat)", "Arrow (3D)", "Axes")),
        Property("Color", (0, 180, 0)),
        Property("Alpha", 1.0, low=0.0, high=1.0),
        Property("Min Arrow Length", 0.02, low=0.0, high=1000.0, hint="Of the weight 0"),
        Property("Max Arrow Length", 0.3, low=0.0, high=1000.0, hint="Of the weight 1"),
    )

    def _prepare(self) -> None:
        super()._prepare()
        self.values.given.setdefault("Class", f"nav2_rviz_plugins/{self.rviz_class}")

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a ParticleCloud: arrows or axes, longer for larger weights."""
        low = self.values.number("Min Arrow Length")
        more = max(self.values.number("Max Arrow Length") - low, 0.0)
        by_share: dict[float, list[Any]] = {}
        left_out = 0
        for particle in message.particles:
            if not is_drawable((particle.weight,)):
                left_out += 1
                continue
            share = round(_LENGTHS * min(max(particle.weight, 0.0), 1.0)) / _LENGTHS
            by_share.setdefault(share, []).append(particle.pose)
        drawings = []
        for share, poses in by_share.items():
            positions, rotations, wrong = poses_of(poses)
            left_out += wrong
            drawings.append(self._shape(low + share * more).copied_to(positions, rotations))
        if left_out:
            self.set_status(WARN, not_drawn_text(left_out, "particles"))
        return merged(drawings)

    def _shape(self, length: float) -> Drawing:
        values, drawing = self.values, Drawing()
        alpha = values.number("Alpha")
        color = rgba_of(values.color("Color"), alpha)
        shape = values.text("Shape")
        # RViz's proportions, which are those of the arrows of PoseArray: 0.23, 0.01, 0.07, 0.03.
        if shape == "Axes":
            drawing.axes(Transform(), length, length / 23, alpha)
        elif shape == "Arrow (3D)":
            head, width = length * 7 / 23, length * 2 / 23
            drawing.arrow(Transform(), ArrowSize(length, width, head, 3 * width), color)
        elif alpha > 0.0:
            add_flat_arrow(drawing, length, color)
        return drawing


class PathDisplay(DrawnDisplay):
    """RViz's ``Path`` display: a line through the poses, optionally with arrows or axes."""

    rviz_class = "Path"
    message_type = "nav_msgs/msg/Path"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Color", (25, 255, 0)),
        Property("Alpha", 1.0, low=0.0, high=1.0, hint="0 hides the line"),
        Property("Line Style", "Lines", choices=("Lines", "Billboards")),
        Property("Line Width", 0.03, low=0.001, high=100.0, hint="Metres, of billboards"),
        Property("Buffer Length", 1, low=1, high=1000, hint="Number of paths to keep"),
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
    def history_length(self) -> int:
        """Largest number of paths drawn at a time: the property ``Buffer Length``."""
        return int(self.values.number("Buffer Length"))

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a Path: a line, and optional arrows or axes at its poses."""
        values = self.values
        positions, rotations, left_out = poses_of(one.pose for one in message.poses)
        if left_out:
            self.set_status(WARN, not_drawn_text(left_out, "poses"))
        drawing = self._pose_shape().copied_to(positions, rotations)
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

"""``PoseDisplay`` and ``PoseWithCovariance``: where something stands, as an arrow or axes."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.viewer.displays.base import ERROR, WARN
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.geometry.covariance import COVARIANCE_PROPERTIES, draw_covariance
from teleopctl.viewer.displays.geometry.pose_shape import draw_pose, shape_properties
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import pose_of
from teleopctl.viewer.scene.drawing import Drawing

# Any stands for messages throughout: their classes are made at run time, from definitions.

NOT_FINITE = "The pose is not drawn: its numbers must be finite"


class PoseDisplay(DrawnDisplay):
    """Display of a stamped pose."""

    rviz_class = "Pose"
    message_type = "geometry_msgs/msg/PoseStamped"
    properties: ClassVar[tuple[Property, ...]] = shape_properties()

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of the pose's shape."""
        drawing = Drawing()
        pose = pose_of(message.pose)
        if pose is None:
            self.say(ERROR, NOT_FINITE)
        else:
            draw_pose(drawing, pose, self.values)
        return drawing


class PoseWithCovariance(DrawnDisplay):
    """Display of a stamped pose with covariance."""

    rviz_class = "PoseWithCovariance"
    message_type = "geometry_msgs/msg/PoseWithCovarianceStamped"
    properties: ClassVar[tuple[Property, ...]] = (*shape_properties(), *COVARIANCE_PROPERTIES)

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of the pose's shape and covariance."""
        drawing = Drawing()
        pose = pose_of(message.pose.pose)
        if pose is None:
            self.say(ERROR, NOT_FINITE)
            return drawing
        draw_pose(drawing, pose, self.values)
        fault = draw_covariance(drawing, pose, list(message.pose.covariance), self.values)
        if fault:
            self.say(WARN, fault)
        return drawing

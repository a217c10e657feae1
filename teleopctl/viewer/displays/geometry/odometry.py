"""``OdometryDisplay``: where a robot has been, one shape for every few centimetres."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import ERROR, WARN
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.geometry.covariance import COVARIANCE_PROPERTIES, draw_covariance
from teleopctl.viewer.displays.geometry.pose import NOT_FINITE
from teleopctl.viewer.displays.geometry.pose_shape import draw_pose, shape_properties
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import length_of, pose_of
from teleopctl.viewer.scene.drawing import Drawing, merged

# Any stands for messages throughout: their classes are made at run time, from definitions.

# RViz keeps all where the file says 0; memory must not grow over days.
_MOST_KEPT = 10_000


class OdometryDisplay(DrawnDisplay):
    """Display of the last odometry poses, with the covariance of the newest."""

    rviz_class = "Odometry"
    message_type = "nav_msgs/msg/Odometry"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Position Tolerance", 0.1, low=0.0, high=1000.0, hint="Metres to the next shape"),
        Property("Angle Tolerance", 0.1, low=0.0, high=10.0, hint="Radians to the next shape"),
        Property("Keep", 100, low=0, high=_MOST_KEPT, hint="How many poses are drawn"),
        *shape_properties("Shape"),
        *COVARIANCE_PROPERTIES,
    )

    def _prepare(self) -> None:
        super()._prepare()
        self._last: Transform | None = None
        self._covariance = Drawing()

    @property
    def keeps(self) -> int:
        """Number of poses that are drawn."""
        return int(self.values.number("Keep")) or _MOST_KEPT

    def received(self, message: Any) -> None:
        """Add a pose if it differs enough from the last one."""
        pose = pose_of(message.pose.pose)
        if pose is None:
            self.say(ERROR, NOT_FINITE)
        elif self._last is None or self._differs(self._last, pose):
            self._last = pose
            super().received(message)

    def stopped(self) -> None:
        """Clear the poses."""
        self._last = None
        super().stopped()

    def placed(self, message: Any, pose: Transform) -> None:
        """Add a pose to the drawn ones."""
        self._covariance = Drawing()
        super().placed(message, pose)
        self._covariance = self._covariance.moved(pose)

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a pose; the newest one has its covariance."""
        drawing = Drawing()
        pose = pose_of(message.pose.pose)
        if pose is not None:
            draw_pose(drawing, pose, self.values, "Shape")
            numbers = list(message.pose.covariance)
            fault = draw_covariance(self._covariance, pose, numbers, self.values)
            if fault:
                self.say(WARN, fault)
        return drawing

    def whole(self) -> Drawing:
        """Return the drawing of all poses, with the newest one's covariance."""
        return merged([super().whole(), self._covariance])

    def emptied(self) -> None:
        """Clear all drawings."""
        self._covariance = Drawing()
        super().emptied()

    def _differs(self, last: Transform, pose: Transform) -> bool:
        step = (last.inverse() @ pose).translation
        if length_of(*step) > self.values.number("Position Tolerance"):
            return True
        cosine = abs(sum(a * b for a, b in zip(last.rotation, pose.rotation, strict=True)))
        return 2 * math.acos(min(cosine, 1.0)) > self.values.number("Angle Tolerance")

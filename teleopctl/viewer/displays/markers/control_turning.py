"""How a control of an interactive marker is turned: with its marker, not at all, or to the viewer.

As RViz does it; all rotations are in the frame of the interactive marker's header.
"""

from __future__ import annotations

import math
from typing import Any

from teleopctl.tf import Quaternion, Transform
from teleopctl.viewer.scene.drawing import is_drawable, unit_rotation

# Any stands for messages: their classes are made at run time, from definitions.

INHERIT, FIXED, VIEW_FACING = 0, 1, 2


class ControlTurning:
    """Orientation of an interactive marker's control.

    Args:
        control: The ``visualization_msgs/msg/InteractiveMarkerControl``.

    Attributes:
        axes: The control's axes in itself: it acts along the first, about it, or across it.
        faces_viewer: Whether it is turned to whoever looks, `face` says from where.
        carries_markers: Whether its markers are turned as it is, and not as the interactive marker.
        angle: How far it has been turned about its own axis by hand.
    """

    def __init__(self, control: Any) -> None:
        q = control.orientation
        turn = (q.x, q.y, q.z, q.w)
        self.axes = Transform(
            rotation=unit_rotation(*turn) if is_drawable(turn) else (0.0, 0.0, 0.0, 1.0)
        )
        self._mode = control.orientation_mode
        self.faces_viewer = self._mode == VIEW_FACING
        self.carries_markers = self._mode == FIXED or (
            self.faces_viewer and not control.independent_marker_orientation
        )
        self.angle = 0.0
        self._view = Transform()

    def face(self, view: Quaternion) -> bool:
        """Turn the control toward a camera; return whether it has changed."""
        if not self.faces_viewer or view == self._view.rotation:
            return False
        self._view = Transform(rotation=view)
        return True

    def beside(self, marker: Transform) -> Transform:
        """Return the pose of the control for a pose of its interactive marker.

        Args:
            marker: The pose of the interactive marker.
        """
        if self._mode == FIXED:
            turned = _about(self._axis(self.axes), self.angle)
        elif self.faces_viewer:
            turned = _about(self._axis(self._view), self.angle) @ self._view @ self.axes.inverse()
        else:
            return marker
        return Transform(marker.translation, turned.rotation)

    def angle_of(self, turn: Transform, marker: Transform) -> float:
        """Return the angle of a rotation about the control's axis, in radians."""
        ax, ay, az = self._axis(self.beside(marker) @ self.axes)
        x, y, z, w = turn.rotation
        return 2.0 * math.atan2(x * ax + y * ay + z * az, w)

    @staticmethod
    def _axis(axes: Transform) -> tuple[float, float, float]:
        return (Transform(rotation=axes.rotation) @ Transform((1.0, 0.0, 0.0))).translation


def _about(axis: tuple[float, float, float], angle: float) -> Transform:
    s = math.sin(angle / 2.0)
    return Transform(rotation=(axis[0] * s, axis[1] * s, axis[2] * s, math.cos(angle / 2.0)))

"""One control of an interactive marker: its orientation, its viser gizmo and its markers.

The behaviour is RViz's. All rotations are in the frame of the interactive marker's header.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from teleopctl.tf import Quaternion, Transform
from teleopctl.viewer.displays.markers.marker_drawing import MarkerError, draw_marker, marker_pose
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing, Text, is_drawable, merged, unit_rotation

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.displays.base import Stage

# Any: messages, whose classes are created from definitions at run time.

INHERIT, FIXED, VIEW_FACING = 0, 1, 2


class ControlOrientation:
    """Orientation of an interactive marker's control: inherited, fixed or facing the camera.

    Args:
        control: The ``visualization_msgs/msg/InteractiveMarkerControl``.

    Attributes:
        axes: Orientation in the message; the control acts along, about or across its x axis.
        faces_viewer: Whether the control faces the camera; see `face_camera`.
        carries_markers: Whether the control's markers have its orientation, instead of that of the
            interactive marker.
        angle: Angle in radians by which the user has rotated the control about its own axis.
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

    def face_camera(self, camera_rotation: Quaternion) -> bool:
        """Set the camera's rotation; return whether the control's orientation changes."""
        if not self.faces_viewer or camera_rotation == self._view.rotation:
            return False
        self._view = Transform(rotation=camera_rotation)
        return True

    def pose_for(self, marker_pose: Transform) -> Transform:
        """Return the control's pose for an interactive marker at ``marker_pose``."""
        if self._mode == FIXED:
            turned = _rotation_about(self._axis(self.axes), self.angle)
        elif self.faces_viewer:
            turned = (
                _rotation_about(self._axis(self._view), self.angle)
                @ self._view
                @ self.axes.inverse()
            )
        else:
            return marker_pose
        return Transform(marker_pose.translation, turned.rotation)

    def angle_of(self, rotation: Transform, marker_pose: Transform) -> float:
        """Return the angle (rad) of a rotation about the x axis of a control at a marker pose.

        Args:
            rotation: Rotation in the frame of the interactive marker's header.
            marker_pose: Pose of the interactive marker, which determines the axis.
        """
        ax, ay, az = self._axis(self.pose_for(marker_pose) @ self.axes)
        x, y, z, w = rotation.rotation
        return 2.0 * math.atan2(x * ax + y * ay + z * az, w)

    @staticmethod
    def _axis(axes: Transform) -> tuple[float, float, float]:
        return (Transform(rotation=axes.rotation) @ Transform((1.0, 0.0, 0.0))).translation


def _rotation_about(axis: tuple[float, float, float], angle: float) -> Transform:
    s = math.sin(angle / 2.0)
    return Transform(rotation=(axis[0] * s, axis[1] * s, axis[2] * s, math.cos(angle / 2.0)))


NONE, MENU, BUTTON, MOVE_AXIS, MOVE_PLANE, ROTATE_AXIS = 0, 1, 2, 3, 4, 5
MOVE_ROTATE, MOVE_3D, ROTATE_3D, MOVE_ROTATE_3D = 6, 7, 8, 9


@dataclass(frozen=True, slots=True)
class _Parts:
    """Parts of viser's gizmo that a control has; rings and planes need both of their axes."""

    active: tuple[bool, bool, bool]
    arrows: bool = False
    planes: bool = False
    rings: bool = False


# A control acts along or about its x axis, or in the plane perpendicular to that axis.
_NEARLY_ALONG = 0.9999
_X, _YZ, _ALL = (True, False, False), (False, True, True), (True, True, True)
_PARTS = {
    MOVE_AXIS: _Parts(_X, arrows=True),
    MOVE_PLANE: _Parts(_YZ, planes=True),
    ROTATE_AXIS: _Parts(_YZ, rings=True),
    MOVE_ROTATE: _Parts(_YZ, planes=True, rings=True),
    MOVE_3D: _Parts(_ALL, arrows=True, planes=True),
    ROTATE_3D: _Parts(_ALL, rings=True),
    MOVE_ROTATE_3D: _Parts(_ALL, arrows=True, planes=True, rings=True),
}

Moved = Callable[[str, str, Transform], object]
"""Function called with phase (start, update or end), control name and new marker pose."""


class ControlGizmo:
    """viser's transform gizmo for one control that moves or rotates its marker.

    Args:
        stage: The viewer's node.
        path: Path of the gizmo in the scene.
        control: The ``visualization_msgs/msg/InteractiveMarkerControl``.
        turning: Orientation of the control.
        scale: The marker's size in metres.
        moved: Function called when the user drags the gizmo.
    """

    def __init__(
        self,
        stage: Stage,
        path: str,
        control: Any,
        turning: ControlOrientation,
        scale: float,
        moved: Moved,
    ) -> None:
        self._name = str(control.name)
        self._turning = turning
        self._turn = turning.axes
        self._keeps_angle = control.interaction_mode in (ROTATE_AXIS, MOVE_ROTATE)
        parts = _PARTS[control.interaction_mode]
        active = parts.active
        # A control along an axis of the marker is drawn as that axis, in the axis's colour.
        own_axis = _own_axis(self._turn)
        if active != _ALL and own_axis is not None:
            first, *_ = active
            active = _one_hot(own_axis, first)
            self._turn = Transform()
        self._moved = moved
        self._pose = Transform()
        # Poses of marker and gizmo, and angle of the control, at the start of the drag.
        self._grabbed = Transform()
        self._grabbed_at = Transform()
        self._grabbed_angle = 0.0
        self.node: viser.TransformControlsHandle = stage.scene.add_transform_controls(
            path,
            scale,
            active_axes=active,
            disable_axes=not parts.arrows,
            disable_sliders=not parts.planes,
            disable_rotations=not parts.rings,
            depth_test=False,
        )
        report = stage.on_node_thread(self._dragged)

        # A coroutine, which viser calls in its event loop: calls in threads could be out of order.
        async def updated(event: viser.TransformControlsEvent) -> None:
            w, x, y, z = (float(part) for part in event.target.wxyz)
            px, py, pz = (float(part) for part in event.target.position)
            report(event.phase, Transform((px, py, pz), unit_rotation(x, y, z, w)))

        self.node.on_update(updated)

    def set_pose(self, pose: Transform) -> None:
        """Move the gizmo to its control's place on an interactive marker at ``pose``."""
        self._pose = pose
        set_node_pose(self.node, self._turning.pose_for(pose) @ self._turn)

    def _dragged(self, phase: str, held: Transform) -> None:
        if phase == "start":
            self._grabbed = self._pose
            self._grabbed_at = self._turning.pose_for(self._pose) @ self._turn
            self._grabbed_angle = self._turning.angle
        # The marker is rotated by the gizmo's rotation.
        turn = Transform(rotation=(held @ self._grabbed_at.inverse()).rotation)
        if self._keeps_angle:
            self._turning.angle = self._grabbed_angle + self._turning.angle_of(turn, self._grabbed)
        rotation = (turn @ Transform(rotation=self._grabbed.rotation)).rotation
        self._moved(phase, self._name, Transform(held.translation, rotation))


def _own_axis(turn: Transform) -> int | None:
    """Return the marker's axis that is parallel to a control's x axis, or None."""
    along = (turn @ Transform((1.0, 0.0, 0.0))).translation
    return next((axis for axis, part in enumerate(along) if abs(part) > _NEARLY_ALONG), None)


def _one_hot(axis: int, value: bool) -> tuple[bool, bool, bool]:
    """Return a value for one axis, and the opposite for the two others."""
    x, y, z = ((number == axis) == value for number in range(3))
    return (x, y, z)


def moves_marker(control: Any) -> bool:
    """Return whether a control's interaction mode moves or rotates the marker."""
    return control.interaction_mode in _PARTS


# Any: viser's kinds of handles.
def set_node_pose(node: Any, pose: Transform) -> None:
    """Set position and orientation of a viser scene node from a `Transform`."""
    x, y, z, w = pose.rotation
    node.position, node.wxyz = pose.translation, (w, x, y, z)


# Any: messages, whose classes are created at run time, and viser's handles.

# Height of the text of a menu without markers above the origin, below the marker's description, and
# size of its letters, relative to the interactive marker's size.
_MENU_HEIGHT, _MENU_LETTERS = 0.55, 0.15
_WHITE = (1.0, 1.0, 1.0, 1.0)


class InteractiveControl:
    """One control of an interactive marker in the scene: markers, gizmo and clicks.

    Args:
        stage: The viewer's node.
        place: Scene path of the frame that the interactive marker's pose is relative to.
        body: Scene path of the node at that pose.
        number: Index among the interactive marker's controls.
        control: The ``visualization_msgs/msg/InteractiveMarkerControl``.
        scale: The interactive marker's size in metres.
        files: Loader of meshes and textures.
        moved: Function called when the user drags the gizmo.
        clicked: Function called after a click on a marker of the control; None for no clicks.

    Attributes:
        fault: Reason why a marker of the control is not drawn as in its message; empty for none.
        files: Keys of the control's meshes and textures; see `marker_file_key`.
        turning: Orientation of the control.
        handle: Gizmo of the control; None for a control that neither moves nor rotates.
    """

    def __init__(
        self,
        stage: Stage,
        place: str,
        body: str,
        number: int,
        control: Any,
        scale: float,
        files: MarkerFiles,
        moved: Moved,
        clicked: Callable[[Any], object] | None,
    ) -> None:
        self.fault = ""
        self.files: set[str] = set()
        self.turning = ControlOrientation(control)
        self.handle: ControlGizmo | None = None
        self._clicked = clicked
        self._own_node: Any = None
        if moves_marker(control):
            path = f"{place}/handle{number}"
            self.handle = ControlGizmo(stage, path, control, self.turning, scale, moved)
        self._drawing = self._drawn(control, scale, files)
        path = f"{body}/control{number}"
        if self.turning.carries_markers:
            path = f"{place}/control{number}"
            self._own_node = stage.scene.add_frame(path, show_axes=False)
        self._canvas = Canvas(
            stage.scene, path, files.meshes, files.textures, picked=clicked is not None
        )

    def _drawn(self, control: Any, scale: float, files: MarkerFiles) -> Drawing:
        """Return the drawing of the control's markers, or of its text."""
        drawings = []
        for marker in control.markers:
            # As in RViz, a size of 0 is unset and replaced by 1.
            for axis in ("x", "y", "z"):
                if getattr(marker.scale, axis) == 0.0:
                    setattr(marker.scale, axis, 1.0)
            try:
                pose = marker_pose(marker)
                self.files.add(files.request(marker))
                drawing, fault = draw_marker(marker, pose)
                drawings.append(drawing)
            except MarkerError as error:
                fault = str(error)
            self.fault = self.fault or fault
        drawing = merged(drawings)
        if control.interaction_mode == MENU and not control.markers:
            height = _MENU_LETTERS * scale
            words = str(control.description)[:100] or "Menu"
            drawing.texts.append(Text((0.0, 0.0, _MENU_HEIGHT * scale), words, height))
        if control.interaction_mode in (BUTTON, MENU) and not (drawing.solids or drawing.surfaces):
            # Texts receive no clicks in browsers, so a sphere is added below each text.
            for text in drawing.texts:
                x, y, z = text.position
                ball = Transform((x, y, z - 1.2 * text.height))
                drawing.solid("sphere", ball, (text.height,) * 3, _WHITE)
        return drawing

    def refresh(self) -> None:
        """Redraw the control's markers; called when a mesh or texture was loaded."""
        before = self._canvas.nodes
        self._canvas.show(self._drawing)
        if self._clicked is None:
            return
        for name, node in self._canvas.nodes.items():
            if before.get(name) is not node and hasattr(node, "on_click"):
                node.on_click(self._clicked)

    def set_marker_pose(self, pose: Transform, *, with_handle: bool = True) -> None:
        """Move the control's markers and gizmo to an interactive marker's pose.

        Args:
            pose: Pose of the interactive marker.
            with_handle: Whether to move the gizmo too; False for the gizmo that the user drags.
        """
        if self._own_node is not None:
            set_node_pose(self._own_node, self.turning.pose_for(pose))
        if self.handle is not None and with_handle:
            self.handle.set_pose(pose)

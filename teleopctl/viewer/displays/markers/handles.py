"""What can be dragged of an interactive marker: one gizmo for each control that moves or turns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from teleopctl.tf import Transform
from teleopctl.viewer.displays.markers.control_turning import ControlTurning
from teleopctl.viewer.scene.drawing import unit_rotation

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.displays.base import Stage

# Any stands for messages: their classes are made at run time, from definitions.

NONE, MENU, BUTTON, MOVE_AXIS, MOVE_PLANE, ROTATE_AXIS = 0, 1, 2, 3, 4, 5
MOVE_ROTATE, MOVE_3D, ROTATE_3D, MOVE_ROTATE_3D = 6, 7, 8, 9


@dataclass(frozen=True, slots=True)
class _Parts:
    """Which parts of viser's gizmo a control has; rings and planes need both of their axes."""

    active: tuple[bool, bool, bool]
    arrows: bool = False
    planes: bool = False
    rings: bool = False


# A control acts along its x axis, about it, or in the plane across it.
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
"""Called with the phase (start, update or end), the control's name, and the marker's new pose."""


class ControlGizmo:
    """viser gizmo of one control.

    Args:
        stage: Where to draw.
        path: The name of its node.
        control: The message.
        turning: How the control is turned.
        scale: The marker's size in metres.
        moved: Whom to tell of what a person does.
    """

    def __init__(
        self,
        stage: Stage,
        path: str,
        control: Any,
        turning: ControlTurning,
        scale: float,
        moved: Moved,
    ) -> None:
        self._name = str(control.name)
        self._turning = turning
        self._turn = turning.axes
        self._keeps_angle = control.interaction_mode in (ROTATE_AXIS, MOVE_ROTATE)
        parts = _PARTS[control.interaction_mode]
        active = parts.active
        # Most controls act along an axis of the marker: its own axis is drawn, in its own colour.
        own_axis = _own_axis(self._turn)
        if active != _ALL and own_axis is not None:
            first, *_ = active
            active = _one_hot(own_axis, first)
            self._turn = Transform()
        self._moved = moved
        self._pose = Transform()
        # Where the marker and the gizmo stood, and how the control was turned, when it was grabbed.
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
        tell = stage.on(self._tell)

        # In viser's loop, since its threads would mix up the order of what a hand does.
        async def note(event: viser.TransformControlsEvent) -> None:
            w, x, y, z = (float(part) for part in event.target.wxyz)
            px, py, pz = (float(part) for part in event.target.position)
            tell(event.phase, Transform((px, py, pz), unit_rotation(x, y, z, w)))

        self.node.on_update(note)

    def place(self, pose: Transform) -> None:
        """Set the gizmo's pose."""
        self._pose = pose
        put(self.node, self._turning.beside(pose) @ self._turn)

    def _tell(self, phase: str, held: Transform) -> None:
        if phase == "start":
            self._grabbed = self._pose
            self._grabbed_at = self._turning.beside(self._pose) @ self._turn
            self._grabbed_angle = self._turning.angle
        # What the gizmo is turned by, the marker is turned by.
        turn = Transform(rotation=(held @ self._grabbed_at.inverse()).rotation)
        if self._keeps_angle:
            self._turning.angle = self._grabbed_angle + self._turning.angle_of(turn, self._grabbed)
        rotation = (turn @ Transform(rotation=self._grabbed.rotation)).rotation
        self._moved(phase, self._name, Transform(held.translation, rotation))


def _own_axis(turn: Transform) -> int | None:
    """The axis of the marker along which a control's x axis lies; None for a slanting one."""
    along = (turn @ Transform((1.0, 0.0, 0.0))).translation
    return next((axis for axis, part in enumerate(along) if abs(part) > _NEARLY_ALONG), None)


def _one_hot(axis: int, value: bool) -> tuple[bool, bool, bool]:
    """That value for one axis, and the opposite for the others."""
    x, y, z = ((number == axis) == value for number in range(3))
    return (x, y, z)


def has_handle(control: Any) -> bool:
    """Return whether a control moves or rotates its marker."""
    return control.interaction_mode in _PARTS


# Any stands for viser's kinds of handles.
def put(node: Any, pose: Transform) -> None:
    """Set the pose of a scene node."""
    x, y, z, w = pose.rotation
    node.position, node.wxyz = pose.translation, (w, x, y, z)

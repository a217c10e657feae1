"""One interactive marker in the scene: its controls, description and menu."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.base.printable import printable_line
from teleopctl.tf import Transform, TransformException
from teleopctl.viewer.displays.conversions import pose_of
from teleopctl.viewer.displays.markers.interactive_control import (
    BUTTON,
    MENU,
    InteractiveControl,
    set_node_pose,
)
from teleopctl.viewer.displays.markers.marker_drawing import MarkerError
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.displays.stamped import pose_at_stamp
from teleopctl.viewer.scene.drawing import is_drawable

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Any: messages, whose classes are created from definitions at run time.

FEEDBACK_KEEP_ALIVE, POSE_UPDATE, MENU_SELECT, BUTTON_CLICK, MOUSE_DOWN, MOUSE_UP = range(6)
_MOST_ENTRIES = 40
_LONGEST_TITLE = 60

PublishFeedback = Callable[[int, str, int], object]
"""Function that publishes feedback: event type, name of the control, ID of the menu entry."""


class InteractiveMarker:
    """One interactive marker in the scene, which publishes feedback of drags and clicks.

    Args:
        stage: The viewer's node.
        path: Scene path of the marker, below its frame's path if the marker moves with its frame.
        message: The ``visualization_msgs/msg/InteractiveMarker``.
        files: Loader of meshes and textures.
        publish_feedback: Function that publishes feedback of the marker.
        show_description: Whether to show the description above the marker.
        show_axes: Whether to draw the marker's axes.

    Attributes:
        message: Message of the marker.
        pose: Pose in the frame of the message's header.
        held: Name of the control that the user drags; empty for none.
        fault: Reason why a part is not drawn as in the message; empty for none.
        files: Keys of the marker's meshes and textures; see `marker_file_key`.

    Raises:
        MarkerError: The marker cannot be drawn at all.
    """

    def __init__(
        self,
        stage: Stage,
        path: str,
        message: Any,
        files: MarkerFiles,
        publish_feedback: PublishFeedback,
        *,
        show_description: bool,
        show_axes: bool,
    ) -> None:
        pose = pose_of(message.pose)
        if pose is None or not is_drawable((message.scale,)):
            raise MarkerError("has numbers that are not finite")
        self.message = message
        self.pose = pose
        self.held = ""
        self._stage = stage
        self._publish_feedback = publish_feedback
        self._placed = False
        self._standing = Transform()
        frame = message.header.frame_id
        stamp = message.header.stamp
        # A marker without stamp moves with its frame.
        self._is_locked = bool(frame) and not stamp.sec and not stamp.nanosec
        above = stage.frames.node_path(frame) if self._is_locked else ""
        scale = float(message.scale) if message.scale > 0 else 1.0
        scene = stage.scene
        self._place = scene.add_frame(f"{above}{path}", show_axes=False)
        self._body: Any = scene.add_frame(
            f"{above}{path}/body",
            show_axes=show_axes,
            axes_length=scale / 2,
            axes_radius=scale / 40,
        )
        if show_description and message.description:
            scene.add_label(
                f"{self._body.name}/description",
                message.description[:500],
                position=(0.0, 0.0, 0.75 * scale),
                anchor="bottom-center",
            )
        self._controls = [
            InteractiveControl(
                stage,
                self._place.name,
                self._body.name,
                number,
                control,
                scale,
                files,
                self._moved,
                self._click_of(control),
            )
            for number, control in enumerate(message.controls)
        ]
        self.fault = next((one.fault for one in self._controls if one.fault), "")
        self.files = set().union(*(one.files for one in self._controls))
        self._facing = [one for one in self._controls if one.turning.faces_viewer]
        self._menu: Any = None
        self.refresh()
        self._move_all()
        self.update_pose()

    def refresh(self) -> None:
        """Redraw the markers of all controls; called when a mesh or texture was loaded."""
        for control in self._controls:
            control.refresh()

    # Any: viser's events.
    def _click_of(self, control: Any) -> Callable[[Any], object] | None:
        """Return the callback for clicks on a control, or None."""
        name = str(control.name)
        if control.interaction_mode == BUTTON:
            return self._stage.on_node_thread(lambda _event: self._press(name))
        if control.interaction_mode == MENU or self.message.menu_entries:
            return self._stage.on_node_thread(lambda event: self._open_menu(event.client.gui, name))
        return None

    @property
    def faces_viewer(self) -> bool:
        """Whether at least one control of the marker faces the camera."""
        return bool(self._facing)

    def face_camera(self, camera_pose: Transform) -> None:
        """Rotate the controls that face the camera, unless the user drags the marker.

        Args:
            camera_pose: The camera's pose in the fixed frame; see `Stage.camera`.
        """
        if self.held:
            return
        above = self._standing
        if self._is_locked:
            frame = self._stage.frames.by_name.get(self.message.header.frame_id.removeprefix("/"))
            above = (frame.pose if frame is not None else None) or Transform()
        view = (above.inverse() @ camera_pose).rotation
        for control in self._facing:
            if control.turning.face_camera(view):
                control.set_marker_pose(self.pose)

    def update_pose(self) -> None:
        """Place a stamped marker by the transform at its stamp, hidden until that is known.

        A marker without a stamp moves with its frame, whose scene node is above the marker's.
        """
        if self._placed:
            return
        if self._is_locked:
            self._placed = True
            return
        self._place.visible = False
        try:
            self._standing = pose_at_stamp(self._stage.frames, self.message.header)
        except TransformException:
            return
        set_node_pose(self._place, self._standing)
        self._place.visible = True
        self._placed = True

    @property
    def is_placed(self) -> bool:
        """Whether the transform from the marker's frame to the fixed frame is known."""
        frame = self._stage.frames.by_name.get(self.message.header.frame_id.removeprefix("/"))
        return self._placed and (
            not self._is_locked or (frame is not None and frame.pose is not None)
        )

    def reset_pose(self) -> None:
        """Look up the marker's pose again; called after the fixed frame has changed."""
        self._placed = False
        self.update_pose()

    def set_pose(self, pose: Transform) -> None:
        """Move the marker to a pose published by the server, unless the user drags it."""
        if not self.held:
            self.pose = pose
            self._move_all()

    def remove(self) -> None:
        """Remove the marker from the scene, and close its menu."""
        self._close_menu()
        if self._stage.scene.get_handle_by_name(self._place.name) is self._place:
            self._place.remove()

    # --- input of the user --------------------------------------------------------------------

    def _move_all(self, *, with_handles: bool = True) -> None:
        set_node_pose(self._body, self.pose)
        for control in self._controls:
            control.set_marker_pose(self.pose, with_handle=with_handles)

    def _moved(self, phase: str, control: str, pose: Transform) -> None:
        if phase == "start":
            self.held = control or "?"
            self._publish_feedback(MOUSE_DOWN, control, 0)
            return
        self.pose = pose
        if phase == "update":
            self._move_all(with_handles=False)
            self._publish_feedback(POSE_UPDATE, control, 0)
            return
        self.held = ""
        self._move_all()
        self._publish_feedback(MOUSE_UP, control, 0)

    def _press(self, control: str) -> None:
        for event in (MOUSE_DOWN, BUTTON_CLICK, MOUSE_UP):
            self._publish_feedback(event, control, 0)

    # Any: the GuiApi of the browser in which the marker was clicked.
    def _open_menu(self, gui: Any, control: str) -> None:
        self._close_menu()
        self._menu = gui.add_modal(printable_line(self.message.description or self.message.name))
        with self._menu:
            for number, title in selectable_entries(self.message.menu_entries):
                button = gui.add_button(title)
                button.on_click(self._stage.on_node_thread(self._chooser(control, number)))
            close = gui.add_button("Close", color="gray")
            close.on_click(self._stage.on_node_thread(lambda _event: self._close_menu()))

    def _chooser(self, control: str, number: int) -> Callable[[Any], None]:
        def choose(_event: Any) -> None:
            self._close_menu()
            self._publish_feedback(MENU_SELECT, control, number)

        return choose

    def _close_menu(self) -> None:
        if self._menu is not None:
            self._menu.close()
            self._menu = None


def selectable_entries(entries: list[Any]) -> list[tuple[int, str]]:
    """Return (ID, title) of at most 40 entries without sub-menu, titles as "Menu > Entry".

    Commands of entries, which RViz runs, are ignored: no message from the network starts programs.
    """
    titles = {entry.id: (entry.parent_id, str(entry.title)) for entry in entries}
    parents = {entry.parent_id for entry in entries}
    lines = []
    for entry in entries:
        if entry.id in parents:
            continue
        words, number = [str(entry.title)], entry.parent_id
        while number in titles and len(words) < 5:
            number, title = titles[number]
            words.insert(0, title)
        lines.append(
            (int(entry.id), printable_line(" > ".join(words))[:_LONGEST_TITLE] or "(no title)")
        )
    return lines[:_MOST_ENTRIES]

"""One interactive marker in the picture: what it looks like, its handles, its buttons, its menu."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.base.printable import printable_line
from teleopctl.tf import Transform, TransformException
from teleopctl.viewer.displays.markers.handles import BUTTON, MENU, put
from teleopctl.viewer.displays.markers.interactive_control import InteractiveControl
from teleopctl.viewer.displays.markers.marker_drawing import MarkerFault
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.displays.reading import pose_of
from teleopctl.viewer.displays.stamped import place_of
from teleopctl.viewer.scene.drawing import is_drawable

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Any stands for messages: their classes are made at run time, from definitions.

FEEDBACK_KEEP_ALIVE, POSE_UPDATE, MENU_SELECT, BUTTON_CLICK, MOUSE_DOWN, MOUSE_UP = range(6)
_MOST_ENTRIES = 40
_LONGEST_TITLE = 60

Told = Callable[[int, str, int], object]
"""Called with the kind of event, the control's name, and the entry of the menu."""


class InteractiveMarker:
    """Draws one interactive marker and publishes its feedback.

    Args:
        stage: Where to draw.
        path: The end of its path below its frame's node, or the whole path for one that stands.
        message: The ``visualization_msgs/msg/InteractiveMarker``.
        files: Where meshes and textures come from.
        tell: Whom to tell.
        show_description: Whether its description is written above it.
        show_axes: Whether its axes are drawn.

    Attributes:
        message: As above.
        pose: Where it stands in the frame of its header.
        held: The control that a person holds; empty for none.
        fault: Why it is not drawn as it says.
        files: The keys of its meshes and textures.

    Raises:
        MarkerFault: It cannot be drawn at all.
    """

    def __init__(
        self,
        stage: Stage,
        path: str,
        message: Any,
        files: MarkerFiles,
        tell: Told,
        *,
        show_description: bool,
        show_axes: bool,
    ) -> None:
        pose = pose_of(message.pose)
        if pose is None or not is_drawable((message.scale,)):
            raise MarkerFault("has numbers that are not finite")
        self.message = message
        self.pose = pose
        self.held = ""
        self._stage = stage
        self._tell = tell
        self._placed = False
        self._standing = Transform()
        frame = message.header.frame_id
        stamp = message.header.stamp
        # Without a time it moves with its frame.
        self._is_locked = bool(frame) and not stamp.sec and not stamp.nanosec
        above = stage.frames.node_of(frame) if self._is_locked else ""
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
        self._put_everything()
        self.follow()

    def refresh(self) -> None:
        """Redraw the marker's shapes, when a mesh or texture was loaded."""
        for control in self._controls:
            control.refresh()

    # Any stands for viser's events.
    def _click_of(self, control: Any) -> Callable[[Any], object] | None:
        """What a click on a control does; None for nothing."""
        name = str(control.name)
        if control.interaction_mode == BUTTON:
            return self._stage.on(lambda _event: self._press(name))
        if control.interaction_mode == MENU or self.message.menu_entries:
            return self._stage.on(lambda event: self._open_menu(event.client.gui, name))
        return None

    @property
    def faces_viewer(self) -> bool:
        """Whether a control of the marker turns toward the camera."""
        return bool(self._facing)

    def face(self, camera: Transform) -> None:
        """Turn view-facing controls toward the camera, unless a user drags the marker.

        Args:
            camera: From where it is seen, in the fixed frame; see `Stage.camera`.
        """
        if self.held:
            return
        above = self._standing
        if self._is_locked:
            frame = self._stage.frames.by_name.get(self.message.header.frame_id.removeprefix("/"))
            above = (frame.pose if frame is not None else None) or Transform()
        view = (above.inverse() @ camera).rotation
        for control in self._facing:
            if control.turning.face(view):
                control.place(self.pose)

    def follow(self) -> None:
        """Update the pose by the marker's frame, at its stamp if it has one.

        Raises:
            TransformException: That is not known.
        """
        if self._placed:
            return
        if self._is_locked:
            self._placed = True
            return
        self._place.visible = False
        try:
            self._standing = place_of(self._stage.frames, self.message.header)
        except TransformException:
            return
        put(self._place, self._standing)
        self._place.visible = True
        self._placed = True

    @property
    def is_placed(self) -> bool:
        """Whether the marker's transform is known."""
        frame = self._stage.frames.by_name.get(self.message.header.frame_id.removeprefix("/"))
        return self._placed and (
            not self._is_locked or (frame is not None and frame.pose is not None)
        )

    def place_anew(self) -> None:
        """Update the pose after a change of the fixed frame."""
        self._placed = False
        self.follow()

    def stand_at(self, pose: Transform) -> None:
        """Set the pose that the server publishes, unless a user drags the marker."""
        if not self.held:
            self.pose = pose
            self._put_everything()

    def remove(self) -> None:
        """Remove the marker from the scene."""
        self._close_menu()
        if self._stage.scene.get_handle_by_name(self._place.name) is self._place:
            self._place.remove()

    # --- what a person does -------------------------------------------------------------------

    def _put_everything(self, *, with_handles: bool = True) -> None:
        put(self._body, self.pose)
        for control in self._controls:
            control.place(self.pose, with_handle=with_handles)

    def _moved(self, phase: str, control: str, pose: Transform) -> None:
        if phase == "start":
            self.held = control or "?"
            self._tell(MOUSE_DOWN, control, 0)
            return
        self.pose = pose
        if phase == "update":
            self._put_everything(with_handles=False)
            self._tell(POSE_UPDATE, control, 0)
            return
        self.held = ""
        self._put_everything()
        self._tell(MOUSE_UP, control, 0)

    def _press(self, control: str) -> None:
        for event in (MOUSE_DOWN, BUTTON_CLICK, MOUSE_UP):
            self._tell(event, control, 0)

    # Any stands for the GuiApi of the browser in which the marker was clicked.
    def _open_menu(self, gui: Any, control: str) -> None:
        self._close_menu()
        self._menu = gui.add_modal(printable_line(self.message.description or self.message.name))
        with self._menu:
            for number, title in menu_lines(self.message.menu_entries):
                button = gui.add_button(title)
                button.on_click(self._stage.on(self._chooser(control, number)))
            close = gui.add_button("Close", color="gray")
            close.on_click(self._stage.on(lambda _event: self._close_menu()))

    def _chooser(self, control: str, number: int) -> Callable[[Any], None]:
        def choose(_event: Any) -> None:
            self._close_menu()
            self._tell(MENU_SELECT, control, number)

        return choose

    def _close_menu(self) -> None:
        if self._menu is not None:
            self._menu.close()
            self._menu = None


def menu_lines(entries: list[Any]) -> list[tuple[int, str]]:
    """Return the selectable entries of a marker's menu, each with its path of titles.

    What an entry would run in RViz is not run: a message from the network starts nothing here.
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

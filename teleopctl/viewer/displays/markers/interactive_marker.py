"""One interactive marker in the picture: what it looks like, its handles, its buttons, its menu."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.printable import printable_line
from teleopctl.tf import Transform, TransformException
from teleopctl.viewer.displays.markers.handles import BUTTON, MENU, Handle, has_handle, put
from teleopctl.viewer.displays.markers.marker_drawing import MarkerFault, draw_marker, own_pose
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.displays.reading import pose_of
from teleopctl.viewer.displays.stamped import place_of
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing, is_drawable, merged

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Any stands for messages: their classes are made at run time, from definitions.

FEEDBACK_KEEP_ALIVE, POSE_UPDATE, MENU_SELECT, BUTTON_CLICK, MOUSE_DOWN, MOUSE_UP = range(6)
_MOST_ENTRIES = 40
_LONGEST_TITLE = 60

Told = Callable[[int, str, int], object]
"""Called with the kind of event, the control's name, and the entry of the menu."""


class InteractiveMarker:
    """Draws a marker, and tells what a person does with it.

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
        self.fault = ""
        self.files: set[str] = set()
        self._stage = stage
        self._tell = tell
        self._placed = False
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
        self._handles: dict[str, Handle] = {}
        self._canvases: list[tuple[Any, Canvas, Drawing]] = []
        for number, control in enumerate(message.controls):
            if has_handle(control):
                handle_path = f"{self._place.name}/handle{number}"
                handle = Handle(stage, handle_path, control, scale, self._moved)
                self._handles[handle_path] = handle
            self._draw_control(number, control, files)
        self._menu: Any = None
        self.refresh()
        self._put_everything()
        self.follow()

    def _draw_control(self, number: int, control: Any, files: MarkerFiles) -> None:
        drawings = []
        for marker in control.markers:
            try:
                pose = own_pose(marker)
                self.files.add(files.want(marker))
                drawing, fault = draw_marker(marker, pose)
                drawings.append(drawing)
            except MarkerFault as error:
                fault = str(error)
            self.fault = self.fault or fault
        if drawings:
            path, mode = f"{self._body.name}/control{number}", control.interaction_mode
            picked = mode in (BUTTON, MENU) or bool(self.message.menu_entries)
            canvas = Canvas(self._stage.scene, path, files.meshes, files.textures, picked=picked)
            self._canvases.append((control, canvas, merged(drawings)))

    def refresh(self) -> None:
        """Draw what its markers look like; again when a mesh has arrived."""
        for control, canvas, drawing in self._canvases:
            before = canvas.nodes
            canvas.show(drawing)
            for name, node in canvas.nodes.items():
                if before.get(name) is not node and hasattr(node, "on_click"):
                    self._make_clickable(node, control)

    def _make_clickable(self, node: Any, control: Any) -> None:
        if control.interaction_mode == BUTTON:
            node.on_click(self._stage.on(lambda _event: self._press(str(control.name))))
        elif control.interaction_mode == MENU or self.message.menu_entries:
            node.on_click(
                self._stage.on(lambda event: self._open_menu(event.client.gui, str(control.name)))
            )

    def follow(self) -> None:
        """Stand where its frame stands, or stood at its time.

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
            put(self._place, place_of(self._stage.frames, self.message.header))
        except TransformException:
            return
        self._place.visible = True
        self._placed = True

    @property
    def is_placed(self) -> bool:
        """Whether its place is known."""
        frame = self._stage.frames.by_name.get(self.message.header.frame_id.removeprefix("/"))
        return self._placed and (
            not self._is_locked or (frame is not None and frame.pose is not None)
        )

    def place_anew(self) -> None:
        """Find its place in another fixed frame."""
        self._placed = False
        self.follow()

    def stand_at(self, pose: Transform) -> None:
        """Take a pose of the server's, unless a person holds the marker."""
        if not self.held:
            self.pose = pose
            self._put_everything()

    def remove(self) -> None:
        """Take it out of the picture."""
        self._close_menu()
        if self._stage.scene.get_handle_by_name(self._place.name) is self._place:
            self._place.remove()

    # --- what a person does -------------------------------------------------------------------

    def _put_everything(self, but: str = "") -> None:
        put(self._body, self.pose)
        for path, handle in self._handles.items():
            if path != but:
                handle.place(self.pose)

    def _moved(self, phase: str, control: str, pose: Transform) -> None:
        if phase == "start":
            self.held = control or "?"
            self._tell(MOUSE_DOWN, control, 0)
            return
        self.pose = pose
        if phase == "update":
            put(self._body, pose)
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
    """The entries of a menu that can be chosen, with the titles of those above them.

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

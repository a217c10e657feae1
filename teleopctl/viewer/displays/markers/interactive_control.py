"""One control of an interactive marker in the picture: its markers, its gizmo, what is clicked."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.tf import Transform
from teleopctl.viewer.displays.markers.control_turning import ControlTurning
from teleopctl.viewer.displays.markers.handles import (
    BUTTON,
    MENU,
    ControlGizmo,
    Moved,
    has_handle,
    put,
)
from teleopctl.viewer.displays.markers.marker_drawing import MarkerFault, draw_marker, own_pose
from teleopctl.viewer.displays.markers.marker_files import MarkerFiles
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing, Text, merged

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Any stands for messages and viser's handles: their classes are made at run time.

# Where the words of a menu without markers stand, below the marker's description, and how high they
# are, in parts of the interactive marker's size.
_MENU_HEIGHT, _MENU_LETTERS = 0.55, 0.15
_WHITE = (1.0, 1.0, 1.0, 1.0)


class InteractiveControl:
    """Draws one control of an interactive marker.

    Args:
        stage: Where to draw.
        place: The path of the node in whose frame the interactive marker has its pose.
        body: The path of the node that stands at that pose.
        number: Which of the interactive marker's controls it is.
        control: The message.
        scale: The interactive marker's size in metres.
        files: Where meshes and textures come from.
        moved: Whom to tell of what a person does with its gizmo.
        clicked: Whom to tell of a click; None where clicks mean nothing.

    Attributes:
        fault: Why it is not drawn as it says.
        files: The keys of its meshes and textures.
        turning: How it is turned.
        handle: Its gizmo; None for one that neither moves nor turns.
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
        self.turning = ControlTurning(control)
        self.handle: ControlGizmo | None = None
        self._clicked = clicked
        self._own_node: Any = None
        if has_handle(control):
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
        """What its markers look like."""
        drawings = []
        for marker in control.markers:
            # As RViz completes them: a size that is not set is 1.
            for axis in ("x", "y", "z"):
                if getattr(marker.scale, axis) == 0.0:
                    setattr(marker.scale, axis, 1.0)
            try:
                pose = own_pose(marker)
                self.files.add(files.want(marker))
                drawing, fault = draw_marker(marker, pose)
                drawings.append(drawing)
            except MarkerFault as error:
                fault = str(error)
            self.fault = self.fault or fault
        drawing = merged(drawings)
        if control.interaction_mode == MENU and not control.markers:
            height = _MENU_LETTERS * scale
            words = str(control.description)[:100] or "Menu"
            drawing.texts.append(Text((0.0, 0.0, _MENU_HEIGHT * scale), words, height))
        if control.interaction_mode in (BUTTON, MENU) and not (drawing.solids or drawing.surfaces):
            # Browsers do not find words under the mouse: a ball below them is what is clicked.
            for text in drawing.texts:
                x, y, z = text.position
                ball = Transform((x, y, z - 1.2 * text.height))
                drawing.solid("sphere", ball, (text.height,) * 3, _WHITE)
        return drawing

    def refresh(self) -> None:
        """Redraw the control's markers, when a mesh or texture was loaded."""
        before = self._canvas.nodes
        self._canvas.show(self._drawing)
        if self._clicked is None:
            return
        for name, node in self._canvas.nodes.items():
            if before.get(name) is not node and hasattr(node, "on_click"):
                node.on_click(self._clicked)

    def place(self, pose: Transform, *, with_handle: bool = True) -> None:
        """Set the pose of the control's marker.

        Args:
            pose: Its pose.
            with_handle: Whether its gizmo goes along; one that a hand holds is where the hand is.
        """
        if self._own_node is not None:
            put(self._own_node, self.turning.beside(pose))
        if self.handle is not None and with_handle:
            self.handle.place(pose)

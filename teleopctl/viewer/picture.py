"""The picture: displays over a view, which an ``.rviz`` file can hold."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl import plugins
from teleopctl.base.printable import printable_line
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import Display, Stage
from teleopctl.viewer.displays.robot_model import RobotModelDisplay
from teleopctl.viewer.framing import round_number, seen_from, view_of
from teleopctl.viewer.rviz_file import RvizFile, View
from teleopctl.viewer.rviz_leftovers import leftovers
from teleopctl.viewer.scene.lights import light

if TYPE_CHECKING:
    import viser

# What is in the picture where no file says otherwise: class, name, properties.
_DEFAULT_DISPLAYS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("Grid", "Grid", {"Cell Size": 0.5, "Plane Cell Count": 20, "Color": "60; 62; 66"}),
    ("RobotModel", "RobotModel", {"Description Topic": {"Value": "/robot_description"}}),
    ("TF", "TF", {"Enabled": False, "Value": False, "Marker Scale": 0.5}),
)
_SIMULATED_WORLD: tuple[str, str, dict[str, Any]] = (
    "MarkerArray",
    "World",
    {"Topic": {"Value": "/mujoco_sim/world_markers"}},
)
_DEFAULT_VIEW = View((1.5, -1.5, 1.1), (0.0, 0.0, 0.35))


class SceneView:
    """The 3D view: its displays and its camera.

    Args:
        server: Where to draw.
        stage: What displays work with.
        path: The ``.rviz`` file to begin with and to save to; None is the grid, the robot, in
            simulation the world around it, and, not shown, its frames.
        simulated: Whether the robot is in simulation.

    Attributes:
        displays: What is in the picture, in the order of the list.
        file: The view; it changes with the displays.
        path: Where it is saved; None is wherever the user's browser puts it.

    Raises:
        TeleopctlError: The file cannot be read.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        stage: Stage,
        path: Path | None = None,
        *,
        simulated: bool = False,
    ) -> None:
        self.displays: list[Display] = []
        self._server = server
        self._stage = stage
        self._drawn = False
        self._count = 0
        server.scene.set_up_direction("+z")
        light(server.scene)
        self.path = path
        # A view of the user's own stays as it is.
        self._framed = path is not None
        if path is None:
            self.file = RvizFile()
            world = (_SIMULATED_WORLD,) if simulated else ()
            for rviz_class, name, given in _DEFAULT_DISPLAYS + world:
                self.add(rviz_class, name, copy.deepcopy(given))
        else:
            self.file = RvizFile.load(path)
            self._take(self.file, path)
        self.look_from(self.file.view or _DEFAULT_VIEW)

    def _take(self, file: RvizFile, path: Path) -> None:
        for entry in file.displays():
            if plugins.find(plugins.DISPLAYS, entry.rviz_class) is not None:
                display = self._make(entry.rviz_class, entry.name, entry.given)
                display.in_shown_group = entry.in_shown_group
        if text := leftovers(file, path, self.displays):
            self._stage.node.get_logger().warning(text)
        if file.fixed_frame:
            self._stage.frames.fix(file.fixed_frame)
        if file.background is not None:
            pixel = np.array([[file.background]], np.uint8)
            self._server.scene.set_background_image(pixel)

    # Any stands for what YAML holds.
    def add(self, rviz_class: str, name: str = "", given: dict[str, Any] | None = None) -> Display:
        """Add a display; see `Page.add_display`."""
        given = {} if given is None else given
        display = self._make(rviz_class, name or self._free_name(rviz_class), given)
        self.file.add(rviz_class, display.name, given)
        return display

    def _make(self, rviz_class: str, name: str, given: dict[str, Any]) -> Display:
        kind: type[Display] = plugins.load(plugins.DISPLAYS, rviz_class)
        self._count += 1
        display = kind(self._stage, name, f"/display{self._count}", given)
        self.displays.append(display)
        if self._drawn and display.is_enabled:
            display.begin()
        return display

    def _free_name(self, rviz_class: str) -> str:
        taken = {display.name for display in self.displays}
        numbered = (f"{rviz_class} {number}" for number in range(2, len(taken) + 3))
        return next(name for name in (rviz_class, *numbered) if name not in taken)

    def remove(self, display: Display) -> None:
        """Remove a display."""
        display.end()
        self.displays.remove(display)
        self.file.remove(display.values.given)

    def enable(self, display: Display, *, enabled: bool) -> None:
        """Enable or disable a display."""
        display.in_shown_group = True
        display.values.given["Enabled"] = display.values.given["Value"] = enabled
        if enabled and self._drawn:
            display.begin()
        elif not enabled:
            display.end()

    def begin(self) -> None:
        """Start drawing: a browser shows the page."""
        self._drawn = True
        for display in self.displays:
            if display.is_enabled:
                display.begin()

    def end(self) -> None:
        """Stop drawing, and unsubscribe all displays."""
        self._drawn = False
        for display in self.displays:
            display.end()

    def reset(self) -> None:
        """Clear all displays."""
        for display in self.displays:
            display.reset()

    def tick(self, *, jumped_back: bool) -> None:
        """Update all displays for the next picture.

        Args:
            jumped_back: Whether time has gone back since.
        """
        for display in self.displays:
            display.follow(jumped_back=jumped_back)
        if not self._framed:
            self._frame()

    def _frame(self) -> None:
        """Look at the first robot that is drawn, from as far away as its size asks for."""
        model = next((one for one in self.displays if isinstance(one, RobotModelDisplay)), None)
        if model is None or model.description is None:
            return
        self._framed = True
        self._server.gui.set_panel_label(printable_line(model.description.name) or None)
        view, radius = view_of(model.description, model.meshes)
        self.look_from(view)
        for client in self._server.get_clients().values():
            client.camera.position, client.camera.look_at = view.eye, view.focus
        for display in self.displays:
            if display.rviz_class == "Grid":
                display.set("Cell Size", round_number(radius))
            elif display.rviz_class == "TF":
                display.set("Marker Scale", round_number(radius))

    def look_from(self, view: View) -> None:
        """Set the camera pose of browsers that open the page from now on."""
        self._server.initial_camera.position = view.eye
        self._server.initial_camera.look_at = view.focus

    def camera(self) -> Transform | None:
        """Return the camera's pose; see `Stage.camera`."""
        return seen_from(client.camera for client in self._server.get_clients().values())

    def text(self, camera: viser.CameraHandle | None = None) -> str:
        """Return the view as the text of an ``.rviz`` file.

        Args:
            camera: Whose view to keep; None keeps the one that the picture began with.
        """
        self.file.fixed_frame = self._stage.frames.fixed
        if camera is not None:
            ex, ey, ez = (float(part) for part in camera.position)
            fx, fy, fz = (float(part) for part in camera.look_at)
            self.file.view = View((ex, ey, ez), (fx, fy, fz))
        return self.file.text()

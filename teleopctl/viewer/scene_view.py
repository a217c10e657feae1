"""The 3D view: displays and camera, which an ``.rviz`` file can hold."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl import plugins
from teleopctl.base.printable import printable_line
from teleopctl.robot import Joints, JointSet, RobotDescription, SegmentTree
from teleopctl.tf import Transform, Vector3, quaternion_from_rpy, rpy_from_quaternion
from teleopctl.viewer.displays.base import Display, Stage
from teleopctl.viewer.displays.robot_model import RobotModelDisplay
from teleopctl.viewer.rviz_file import RvizFile, View, unsupported_text
from teleopctl.viewer.scene.assets import MeshFile
from teleopctl.viewer.scene.shapes import bounding_box
from teleopctl.viewer.topic_displays import MOST_SENSORS, display_of

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.client_tracker import PageServer

# Position and intensity of each light. viser's default light shines from straight above, so bright
# that horizontal surfaces are white in every colour.
_LIGHTS = (((1.2, -2.0, 2.6), 1.7), ((-2.0, 0.6, 0.8), 0.5))
_SKY = 0.7


def add_lights(scene: viser.SceneApi) -> None:
    """Replace a viser scene's default lights by two lights without shadows and a sky."""
    scene.configure_default_lights(enabled=False, cast_shadow=False)
    scene.configure_environment_map("city", environment_intensity=_SKY)
    for number, (position, intensity) in enumerate(_LIGHTS):
        scene.add_light_directional(f"/light{number}", position=position, intensity=intensity)


# Direction to the camera: from the front, the right and above.
_DIRECTION = (0.66, -0.6, 0.45)
VIEWS: dict[str, Vector3] = {
    "Whole robot": _DIRECTION,
    "Front": (1.0, 0.0, 0.0),
    "Back": (-1.0, 0.0, 0.0),
    "Left": (0.0, 1.0, 0.0),
    "Right": (0.0, -1.0, 0.0),
    # A camera that looks straight down has no up direction.
    "Top": (-1e-3, 0.0, 1.0),
}
"""Names of views of the whole robot, and the direction from the robot to the camera."""
# Camera distance, in radii of the robot, for a view of the whole robot between the panels.
_RADII = 2.0
# A camera that follows a frame stays where it is while the frame moves by less.
_LEAST_STEP_M = 1e-4
# Time after which a browser has reported the last motion of its camera, s.
_REPORTED_S = 1.0
_SMALLEST_RADIUS_M = 0.02
_LARGEST_RADIUS_M = 1000.0
# viser's camera frame is OpenCV's: x right, y down, z ahead.
_AHEAD_OF_OPTICAL = Transform(rotation=(0.5, -0.5, 0.5, 0.5))


def robot_view(
    description: RobotDescription,
    meshes: Mapping[str, MeshFile],
    direction: Vector3 = _DIRECTION,
) -> tuple[View, float]:
    """Return a `View` of the robot at rest, and half the diagonal of the robot's bounding box (m).

    Args:
        description: Description of the robot.
        meshes: Loaded meshes of the robot by URI.
        direction: Direction from the robot to the camera.

    Returns:
        The view in the frame of the root link, and half the diagonal of the bounding box in metres.
    """
    points = list(_corners(description, meshes)) or [(0.0, 0.0, 0.0)]
    xs, ys, zs = zip(*points, strict=True)
    low, high = (min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs))
    x, y, z = ((least + most) / 2 for least, most in zip(low, high, strict=True))
    radius = min(max(math.dist(low, high) / 2, _SMALLEST_RADIUS_M), _LARGEST_RADIUS_M)
    dx, dy, dz = (_RADII * radius * step for step in direction)
    return View((x + dx, y + dy, z + dz), (x, y, z)), radius


# Heights in pixels of what covers the lower edge of the scene: the bar, and on a phone the sheet of
# viser's client, which has it in windows narrower than 576 pixels.
_BAR_PX, _SHEET_PX, _PHONE_PX = 140, 260, 576
# Beside the bounding sphere of a robot at rest there is room for its motion.
_SEEN_SHARE = 1.1


def fitted(view: View, radius: float, camera: viser.CameraHandle) -> View:
    """Return a view in which a sphere around the focal point is whole, above the page's bar.

    With the window's height h, of which the lowest b pixels are covered, the camera moves back
    until the sphere fits the rest, and down by b / 2 pixels at the sphere's distance.

    Args:
        view: View of the sphere's centre, whose direction is kept.
        radius: Radius of the sphere in metres.
        camera: Camera of the browser, for its size in pixels and its field of view.
    """
    height, width = max(camera.image_height, 1), max(camera.image_width, 1)
    covered = min(_SHEET_PX if width < _PHONE_PX else _BAR_PX, height / 2) / height
    slope = math.tan(camera.fov / 2)
    least = min(slope * (1 - covered), slope * width / height)
    distance = _SEEN_SHARE * radius / math.sin(math.atan(least))
    ahead = np.subtract(view.focus, view.eye)
    ahead /= np.linalg.norm(ahead)
    across = np.cross(ahead, (0.0, 0.0, 1.0))
    up = np.cross(across, ahead) / max(float(np.linalg.norm(across)), 1e-9)
    focus = np.asarray(view.focus) - up * (distance * slope * covered)
    (ex, ey, ez), (fx, fy, fz) = (focus - distance * ahead).tolist(), focus.tolist()
    return View((ex, ey, ez), (fx, fy, fz))


def last_camera_pose(cameras: Iterable[viser.CameraHandle]) -> Transform | None:
    """Return the pose (x ahead, y left, z up) of the camera moved last; None without cameras."""
    camera = max(cameras, key=lambda one: one.update_timestamp, default=None)
    if camera is None:
        return None
    w, x, y, z = (float(part) for part in camera.wxyz)
    px, py, pz = (float(part) for part in camera.position)
    return Transform((px, py, pz), (x, y, z, w)) @ _AHEAD_OF_OPTICAL


def round_down(number: float) -> float:
    """Return the largest number of the series 1, 2, 5, 10, … (or 0.5, 0.2, …) up to a number."""
    power = 10.0 ** math.floor(math.log10(number))
    return power * max(step for step in (1, 2, 5) if step * power <= number * (1 + 1e-9))


def _corners(description: RobotDescription, meshes: Mapping[str, MeshFile]) -> Iterator[Vector3]:
    """Yield the corners of the bounding boxes of all visual geometry, in the root's frame."""
    poses = _poses_at_rest(description)
    for name, link in description.links.items():
        for visual in link.visuals:
            box = bounding_box(visual.geometry, meshes)
            origin = Transform(visual.origin.xyz, quaternion_from_rpy(*visual.origin.rpy))
            for x, y, z in product(*zip(*box, strict=True)) if box is not None else ():
                yield (poses[name] @ origin @ Transform((x, y, z))).translation


def _poses_at_rest(description: RobotDescription) -> dict[str, Transform]:
    joints = Joints.for_display(description, lambda _warning: None)
    rest = JointSet(joints)
    tree = SegmentTree(description, joints)
    local = {segment.joint.child: segment.origin for segment in tree.fixed}
    positions = dict(zip(rest.names, rest.positions(), strict=True))
    for joint, transform in tree.transforms(positions):
        local[joint.child] = transform
    poses = {description.root: Transform()}
    for joint in description.tree:
        poses[joint.child] = poses[joint.parent] @ local.get(joint.child, Transform())
    return poses


# The displays without an .rviz file: class, name, properties.
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


@dataclass(slots=True)
class FollowedFrame:
    """Frame that a browser's camera follows.

    A slow browser reports its camera late: where the camera was some steps ago. So a step is not
    added to what it reports, which would lose steps. The point that the camera looks at keeps its
    offset from the frame; only direction and distance are the reported ones, which steps do not
    change, and people do.

    Attributes:
        frame: Its name.
        at: Where it was at the last step; None before the first one.
        offset: From the frame's origin to the point that the camera looks at.
        moved_s: Time of the last step, on the monotonic clock.
    """

    frame: str
    at: Vector3 | None = None
    offset: Vector3 = (0.0, 0.0, 0.0)
    moved_s: float = 0.0

    def move(self, camera: viser.CameraHandle, at: Vector3) -> None:
        """Move a camera with the frame, to where the frame is now."""
        if self.at is not None and math.dist(at, self.at) <= _LEAST_STEP_M:
            return
        now_s = time.monotonic()
        if self.at is None or now_s - self.moved_s > _REPORTED_S:
            # People may have moved the point since.
            px, py, pz = np.subtract(camera.look_at, at if self.at is None else self.at)
            self.offset = float(px), float(py), float(pz)
        if self.at is not None:
            focus = np.add(at, self.offset)
            camera.position, camera.look_at = focus + (camera.position - camera.look_at), focus
        self.at, self.moved_s = at, now_s


class SceneView:
    """The 3D view of the page: list of displays, ``.rviz`` document and camera.

    Args:
        server: The page's server.
        stage: The viewer's node.
        path: The ``.rviz`` file to load and to save to; None for the default displays: grid, robot,
            tf (disabled) and, in simulation, the world's markers.
        simulated: Whether the robot is simulated.

    Attributes:
        displays: The displays in their order.
        file: The ``.rviz`` document, which changes with the displays.
        path: The file to save to; None for a download by the browser.
        robot_name: Name in the robot description, once it is loaded.

    Raises:
        TeleopctlError: The file cannot be read.
    """

    def __init__(
        self,
        server: PageServer,
        stage: Stage,
        path: Path | None = None,
        *,
        simulated: bool = False,
    ) -> None:
        self.displays: list[Display] = []
        self.robot_name = ""
        self._server = server
        self._stage = stage
        self._drawn = False
        self._count = 0
        # Of each browser whose camera follows a frame.
        self._followed: dict[int, FollowedFrame] = {}
        self._offered: set[str] = set()
        self._sensors = 0
        server.scene.set_up_direction("+z")
        add_lights(server.scene)
        self.path = path
        # The view of a loaded file is kept.
        self._framed = self._is_loaded = path is not None
        if path is None:
            self.file = RvizFile()
            world = (_SIMULATED_WORLD,) if simulated else ()
            for rviz_class, name, given in _DEFAULT_DISPLAYS + world:
                self.add(rviz_class, name, copy.deepcopy(given))
        else:
            self.file = RvizFile.load(path)
            self._load(self.file, path)
        self.set_initial_view(self.file.view or _DEFAULT_VIEW)

    def set_pickable(self, *, pickable: bool) -> None:
        """Choose whether the robots' links can be clicked, or what lies in front of them."""
        for display in self.displays:
            if isinstance(display, RobotModelDisplay):
                display.is_pickable = pickable

    def _load(self, file: RvizFile, path: Path) -> None:
        for entry in file.displays():
            if plugins.find(plugins.DISPLAYS, entry.rviz_class) is not None:
                display = self._make(entry.rviz_class, entry.name, entry.given)
                display.in_shown_group = entry.in_shown_group
        if text := unsupported_text(file, path, self.displays):
            self._stage.node.get_logger().warning(text)
        if file.fixed_frame:
            self._stage.frames.set_fixed_frame(file.fixed_frame)
        if file.background is not None:
            pixel = np.array([[file.background]], np.uint8)
            self._server.scene.set_background_image(pixel)

    def replace(self, text: str) -> None:
        """Draw the displays and the fixed frame of an ``.rviz`` document in place of the present.

        Args:
            text: Text of the document, as `text` returns it.

        Raises:
            TeleopctlError: The text is not that of an ``.rviz`` file.
        """
        file = RvizFile.parse(text, Path("kept displays"))
        for display in tuple(self.displays):
            self.remove(display)
        self.file = file
        for entry in file.displays():
            if plugins.find(plugins.DISPLAYS, entry.rviz_class) is not None:
                display = self._make(entry.rviz_class, entry.name, entry.given)
                display.in_shown_group = entry.in_shown_group
        self._stage.frames.set_fixed_frame(file.fixed_frame)

    # Any: YAML values.
    def add(
        self, rviz_class: str, name: str = "", mapping: dict[str, Any] | None = None
    ) -> Display:
        """Create a display, add it to the view and the ``.rviz`` document, and return it.

        Args:
            rviz_class: RViz class of the display, without package.
            name: Name of the display; if empty, the class, with a number if that name is taken.
            mapping: Mapping of the display in the document; None for the defaults.
        """
        mapping = {} if mapping is None else mapping
        display = self._make(rviz_class, name or self._free_name(rviz_class), mapping)
        self.file.add(rviz_class, display.name, mapping)
        return display

    def offer_topics(self, topics: Iterable[tuple[str, Sequence[str]]]) -> None:
        """Add the displays that come with topics, each once; see `display_of`.

        Of sensors beyond the first `MOST_SENSORS` the displays are switched off.

        Args:
            topics: Topics of the graph with their types.
        """
        if self._is_loaded:
            return
        node = self._stage.node
        published = {
            topic: types
            for topic, types in topics
            if topic in self._offered or node.count_publishers(topic)
        }
        for topic in published:
            offered = None if topic in self._offered else display_of(topic, published)
            if offered is None:
                continue
            rviz_class, name, mapping, is_sensor = offered
            self._offered.add(topic)
            if any(one.topic == topic and one.rviz_class == rviz_class for one in self.displays):
                continue
            self._sensors += is_sensor
            if is_sensor and self._sensors > MOST_SENSORS:
                mapping["Enabled"] = mapping["Value"] = False
            taken = any(display.name == name for display in self.displays)
            self.add(rviz_class, topic if taken else name, mapping)

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
        """End a display, and remove it from the view and the ``.rviz`` document."""
        display.end()
        self.displays.remove(display)
        self.file.remove(display.values.given)

    def enable(self, display: Display, *, enabled: bool) -> None:
        """Enable or disable a display, also in the ``.rviz`` document; start or end its drawing."""
        display.in_shown_group = True
        display.values.given["Enabled"] = display.values.given["Value"] = enabled
        if enabled and self._drawn:
            display.begin()
        elif not enabled:
            display.end()

    def begin(self) -> None:
        """Subscribe and draw the enabled displays; called when a first browser shows the page."""
        self._drawn = True
        for display in self.displays:
            if display.is_enabled:
                display.begin()

    def end(self) -> None:
        """Unsubscribe and undraw all displays; called when no browser shows the page any more."""
        self._drawn = False
        for display in self.displays:
            display.end()

    def reset(self) -> None:
        """Clear all displays and let each subscribe again, as RViz's Reset does."""
        for display in self.displays:
            display.reset()

    def tick(self, *, jumped_back: bool) -> None:
        """Update all displays, and frame a newly loaded robot once; called 30 times a second.

        Args:
            jumped_back: Whether the node's time has jumped back since the last call.
        """
        for display in self.displays:
            display.update(jumped_back=jumped_back)
        if not self._framed:
            self._frame()
        for browser in tuple(self._followed):
            self._follow(browser)

    def follow(self, browser: int, frame: str) -> None:
        """Let a browser's camera move with a frame's origin, keeping its direction.

        Args:
            browser: viser's ID of the browser.
            frame: Name of the frame; empty to stop.
        """
        self._followed.pop(browser, None)
        if frame:
            self._followed[browser] = FollowedFrame(frame)

    def followed(self, browser: int) -> str:
        """Return the frame that a browser's camera follows; empty for none."""
        followed = self._followed.get(browser)
        return "" if followed is None else followed.frame

    def _follow(self, browser: int) -> None:
        followed = self._followed[browser]
        client = self._server.get_clients().get(browser)
        found = self._stage.frames.by_name.get(followed.frame)
        if client is None:
            del self._followed[browser]
        elif found is not None and found.pose is not None:
            followed.move(client.camera, found.pose.translation)

    def _frame(self) -> None:
        """Once a robot is loaded, set camera, grid and axes by its size; only once."""
        model = self._model()
        if model is None or model.description is None:
            return
        self._framed = True
        self.robot_name = printable_line(model.description.name)
        self._server.gui.set_panel_label(self.robot_name or None)
        self._server.set_title(self.robot_name)
        view, radius = robot_view(model.description, model.meshes)
        self.set_initial_view(view)
        for client in self._server.get_clients().values():
            client.camera.position, client.camera.look_at = fitted(view, radius, client.camera)
        for display in self.displays:
            if display.rviz_class == "Grid":
                display.set("Cell Size", round_down(radius))
            elif display.rviz_class == "TF":
                display.set("Marker Scale", round_down(radius))

    def _model(self) -> RobotModelDisplay | None:
        return next((one for one in self.displays if isinstance(one, RobotModelDisplay)), None)

    def frame_usual(self, camera: viser.CameraHandle) -> None:
        """Show the whole robot in a browser that has come, unless an ``.rviz`` file has a view."""
        if self._framed and self.path is None:
            self.frame_robot(camera)

    def frame_robot(self, camera: viser.CameraHandle, direction: Vector3 = _DIRECTION) -> bool:
        """Show the whole robot in one browser, beside the page's bar; return False without robot.

        Args:
            camera: Camera of the browser.
            direction: Direction from the robot to the camera, see `VIEWS`.
        """
        model = self._model()
        if model is None or model.description is None:
            return False
        view, radius = robot_view(model.description, model.meshes, direction)
        view = self._at_robot(view, model.description.root)
        camera.position, camera.look_at = fitted(view, radius, camera)
        return True

    def _at_robot(self, view: View, root: str) -> View:
        """Return a view of a robot at the origin as one of it where it is, by its heading."""
        frame = self._stage.frames.by_name.get(root)
        if frame is None or frame.pose is None:
            return view
        yaw = rpy_from_quaternion(frame.pose.rotation)[2]
        place = Transform(frame.pose.translation, quaternion_from_rpy(0.0, 0.0, yaw))
        eye, focus = (place @ Transform(point) for point in view)
        return View(eye.translation, focus.translation)

    def set_initial_view(self, view: View) -> None:
        """Set the camera's position and focal point for browsers that open the page later."""
        self._server.initial_camera.position = view.eye
        self._server.initial_camera.look_at = view.focus

    def camera(self) -> Transform | None:
        """Return the pose of the camera that was moved last; see `Stage.camera`."""
        return last_camera_pose(client.camera for client in self._server.get_clients().values())

    def text(self, camera: viser.CameraHandle | None = None) -> str:
        """Store fixed frame and camera in the ``.rviz`` document, and return the document's text.

        Args:
            camera: Camera to save; None to keep the document's view.
        """
        self.file.fixed_frame = self._stage.frames.fixed
        if camera is not None:
            ex, ey, ez = (float(part) for part in camera.position)
            fx, fy, fz = (float(part) for part in camera.look_at)
            self.file.view = View((ex, ey, ez), (fx, fy, fz))
        return self.file.text()

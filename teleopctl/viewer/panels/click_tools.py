"""RViz's tools 2D Goal Pose, 2D Pose Estimate, Publish Point and Measure.

A click selects a point of the ground, the plane z = 0 of the fixed frame. A pose takes two clicks,
for position and direction, since dragging rotates the view. Measure takes two points of the robot's
surface or of the ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.interfaces import get_message
from teleopctl.node import QoSProfile
from teleopctl.tf import Transform, Vector3, quaternion_from_rpy
from teleopctl.viewer.displays.robot_model import RobotModelDisplay
from teleopctl.viewer.html import escaped_markdown
from teleopctl.viewer.page_server import PageError
from teleopctl.viewer.rviz_file import RvizFile, class_without_package
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import ArrowSize, Drawing, Rgba
from teleopctl.viewer.scene.surface import Triangles, nearest_hit, robot_triangles

if TYPE_CHECKING:
    from teleopctl.robot import RobotDescription
    from teleopctl.viewer.panels.base import Page

# Any: messages, and viser's events and handles.

_PATH = "/click_tool"
_COLOR: Rgba = (0.0, 0.75, 0.25, 1.0)
# A farther point is treated as the horizon.
_FARTHEST_M = 1e4
_DOT_M = 0.05
# Depth of RViz's publishers.
_DEPTH = 5
# Variances of a pose estimate if the file has none: (0.5 m)^2 and (15 degrees)^2.
_VARIANCES = {"Covariance x": 0.25, "Covariance y": 0.25, "Covariance yaw": (math.pi / 12) ** 2}


@dataclass(frozen=True, slots=True)
class Tool:
    """RViz tool that publishes a message at a clicked point, such as ``2D Goal Pose``.

    Attributes:
        title: Text of the tool's button.
        rviz_class: Class of the tool in ``.rviz`` files, without package.
        message_type: Type of the published message; empty for a tool that publishes nothing.
        topic: Topic of the message, unless an ``.rviz`` file has another.
        has_direction: Whether a second click sets the direction.
    """

    title: str
    rviz_class: str
    message_type: str
    topic: str
    has_direction: bool


TOOLS = (
    Tool("Goal", "SetGoal", "geometry_msgs/msg/PoseStamped", "/goal_pose", True),
    Tool(
        "Estimate",
        "SetInitialPose",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "/initialpose",
        True,
    ),
    Tool("Point", "PublishPoint", "geometry_msgs/msg/PointStamped", "/clicked_point", False),
)

MEASURE = Tool("Measure", "Measure", "", "", True)
"""Tool that shows the distance between two points."""

_MEASURED: Rgba = (1.0, 0.75, 0.1, 1.0)
_LINE_M = 0.004
_POINT_M = 0.012
_ACTIVE = " ✕"


class ClickTools:
    """Buttons for RViz's click tools in the scene panel; at most one tool is active.

    Args:
        page: The viewer's node.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._scene = page.stage.scene
        self._canvas = Canvas(self._scene, _PATH)
        self._tool: Tool | None = None
        self._client_id = -1
        self._where: Vector3 | None = None
        self._fixed = ""
        self._publishers: dict[tuple[str, str], Any] = {}
        self._callback: Callable[..., None] | None = None
        # The measured distance in the scene.
        self._number: Any = None
        # Triangles of each robot's links, by its display, of the description that they belong to.
        self._surfaces: dict[int, tuple[RobotDescription, dict[str, Triangles]]] = {}

    def build(self) -> None:
        """Add the tools' buttons, and a text that guides the user of the active tool."""
        gui = self._page.gui
        self._buttons: Any = gui.add_button_group(
            "Click for",
            self._titles(),
            hint="RViz's 2D Goal Pose, 2D Pose Estimate, Publish Point, and Measure; again to stop",
        )
        self._buttons.on_click(self._page.on_node_thread(self._press))
        self._advice: Any = gui.add_markdown("", visible=False)

    def _titles(self) -> tuple[str, ...]:
        """Return the texts of the buttons; that of the active tool has a cross, to stop it."""
        return tuple(
            tool.title + (_ACTIVE if tool is self._tool else "") for tool in (*TOOLS, MEASURE)
        )

    def _show_buttons(self) -> None:
        if self._titles() != tuple(self._buttons.options):
            self._buttons.options = self._titles()

    @property
    def is_active(self) -> bool:
        """Whether a tool waits for a click."""
        return self._tool is not None

    def deactivate(self) -> None:
        """Deactivate the active tool, and remove its drawing from the scene."""
        self._release()
        self._say("")
        self._canvas.remove()
        self._show_number("", (0.0, 0.0, 0.0))

    def _press(self, event: Any) -> None:
        title = event.target.value.removesuffix(_ACTIVE)
        tool = next(one for one in (*TOOLS, MEASURE) if one.title == title)
        again = tool is self._tool
        self.deactivate()
        if again:
            return
        if not self._page.frames.fixed:
            raise PageError("There is no fixed frame yet: a click has no position")
        if tool is MEASURE:
            self._load_surfaces()
        else:
            # Subscribers discover the publisher while the user aims.
            self._publisher(tool)
        self._tool, self._client_id = tool, event.client_id
        self._show_buttons()
        self._callback = self._page.on_node_thread(self._click)
        self._scene.on_click()(self._callback)
        if tool is MEASURE:
            self._say("Click on two points of the robot or the ground")
        else:
            self._say(f"{tool.title} for {self._topic(tool)}: click on the ground")

    def _click(self, event: Any) -> None:
        tool = self._tool
        # Clicks in other browsers are not for this tool.
        if tool is None or event.client_id != self._client_id:
            return
        if self._fixed != self._page.frames.fixed:
            # The first click was in another fixed frame.
            self._fixed, self._where = self._page.frames.fixed, None
        place = ground_point(event.ray_origin, event.ray_direction)
        if tool is MEASURE:
            place = self._surface_point(event.ray_origin, event.ray_direction, place)
        if place is None:
            self._say("This point is not on the ground: click below the horizon")
        elif tool.has_direction and self._where is None:
            self._where = place
            if tool is MEASURE:
                self._show_number("", place)
                self._draw_measured(place, place)
                self._say("Click on the second point")
            else:
                self._draw(place, None)
                self._say("Click once more to set the direction")
        elif tool is MEASURE and self._where is not None:
            self._show_distance(self._where, place)
        else:
            where, yaw = self._where or place, 0.0
            if tool.has_direction:
                yaw = math.atan2(place[1] - where[1], place[0] - where[0])
            self._publish(tool, where, yaw)

    # --- measuring ------------------------------------------------------------------------------

    def _robots(self) -> list[RobotModelDisplay]:
        displays = self._page.scene_view.displays
        return [one for one in displays if isinstance(one, RobotModelDisplay) and one.is_drawn]

    def _load_surfaces(self) -> None:
        """Read the triangles of the robots, in another thread while the user aims."""
        for robot in self._robots():
            description, key = robot.description, id(robot)
            known = self._surfaces.get(key)
            if description is None or (known is not None and known[0] is description):
                continue

            def take(
                triangles: Any, key: int = key, description: RobotDescription = description
            ) -> None:
                if isinstance(triangles, dict):
                    self._surfaces[key] = description, triangles

            self._page.stage.run_in_background(
                partial(robot_triangles, description, robot.meshes), take
            )

    def _surface_point(
        self, origin: Vector3, direction: Vector3, ground: Vector3 | None
    ) -> Vector3 | None:
        """Return the first intersection of a ray with a robot or the ground."""
        start = (float(origin[0]), float(origin[1]), float(origin[2]))
        along = (float(direction[0]), float(direction[1]), float(direction[2]))
        length = math.hypot(*along) or 1.0
        ways = [] if ground is None else [math.dist(start, ground) / length]
        end = (start[0] + along[0], start[1] + along[1], start[2] + along[2])
        for robot in self._robots():
            _, triangles = self._surfaces.get(id(robot), (None, {}))
            hidden = robot.hidden_links()
            for link, corners in triangles.items():
                frame = self._page.frames.by_name.get(robot.frame_of(link))
                if frame is None or frame.pose is None or link in hidden:
                    continue
                # The ray in the link's frame.
                back = frame.pose.inverse()
                first = (back @ Transform(start)).translation
                last = (back @ Transform(end)).translation
                turned = (last[0] - first[0], last[1] - first[1], last[2] - first[2])
                way = nearest_hit(corners, first, turned)
                if way is not None:
                    ways.append(way)
        if not ways:
            return None
        way = min(ways)
        return start[0] + way * along[0], start[1] + way * along[1], start[2] + way * along[2]

    def _show_distance(self, one: Vector3, two: Vector3) -> None:
        self._where = None
        self._draw_measured(one, two)
        x, y, z = (abs(last - first) for first, last in zip(one, two, strict=True))
        length = f"{math.dist(one, two):.4g} m"
        self._show_number(length, (one[0] + two[0], one[1] + two[1], one[2] + two[2]))
        self._say(
            f"{length}: {x:.4g} along x, {y:.4g} along y, {z:.4g} along z. "
            "Click again for another distance."
        )

    def _show_number(self, text: str, twice: Vector3) -> None:
        """Show a text in the scene at half of a vector, the middle of a line; remove an empty one.

        Args:
            text: The text.
            twice: Sum of the line's ends.
        """
        if self._number is not None:
            self._number.remove()
            self._number = None
        if text:
            x, y, z = (part / 2 for part in twice)
            self._number = self._scene.add_label(f"{_PATH}_number", text, position=(x, y, z))

    def _draw_measured(self, one: Vector3, two: Vector3) -> None:
        drawing = Drawing()
        for point in (one, two):
            drawing.solid("sphere", Transform(point), (_POINT_M,) * 3, _MEASURED)
        if one != two:
            drawing.line(np.array((one, two)), np.array(_MEASURED), _LINE_M, strip=True)
        self._canvas.show(drawing)

    # --- publishing -----------------------------------------------------------------------------

    def _publish(self, tool: Tool, where: Vector3, yaw: float) -> None:
        message = get_message(tool.message_type)()
        message.header.frame_id = self._page.frames.fixed
        message.header.stamp = self._page.node.get_clock().now().to_msg()
        if tool.has_direction:
            pose = message.pose
            if hasattr(pose, "covariance"):
                x, y, around = (self._variance(tool, name) for name in _VARIANCES)
                # Row by row of x, y, z, roll, pitch, yaw.
                pose.covariance[0], pose.covariance[7], pose.covariance[35] = x, y, around
                pose = pose.pose
            turn = quaternion_from_rpy(0.0, 0.0, yaw)
            pose.orientation.z, pose.orientation.w = turn[2], turn[3]
            point = pose.position
        else:
            point = message.point
        point.x, point.y, point.z = where
        publisher = self._publisher(tool)
        publisher.publish(message)
        self._release()
        self._draw(where, yaw if tool.has_direction else None)
        unheard = "" if publisher.get_subscription_count() else "; the topic has no subscriber"
        self._say(f"Published on {self._topic(tool)}: {where[0]:.2f}, {where[1]:.2f}{unheard}")

    def _release(self) -> None:
        if self._callback is not None:
            self._scene.remove_click_callback(self._callback)
        self._callback = self._tool = self._where = None
        self._show_buttons()

    # --- settings of an .rviz file --------------------------------------------------------------

    def _given(self, tool: Tool) -> dict[str, Any]:
        file: RvizFile = self._page.scene_view.file
        named = (one for one in file.tools() if _class_of(one) == tool.rviz_class)
        return next(named, {})

    def _topic(self, tool: Tool) -> str:
        said = self._given(tool).get("Topic")
        if isinstance(said, dict):
            said = said.get("Value")
        return said if isinstance(said, str) and said else tool.topic

    def _variance(self, tool: Tool, name: str) -> float:
        said = self._given(tool).get(name)
        is_variance = isinstance(said, int | float) and 0.0 <= said < math.inf
        return float(said) if said is not None and is_variance else _VARIANCES[name]

    def _publisher(self, tool: Tool) -> Any:
        key = (tool.message_type, self._topic(tool))
        if key not in self._publishers:
            self._publishers[key] = self._page.node.create_publisher(
                get_message(tool.message_type), key[1], QoSProfile(depth=_DEPTH)
            )
        return self._publishers[key]

    # --- drawing --------------------------------------------------------------------------------

    def _draw(self, where: Vector3, yaw: float | None) -> None:
        drawing = Drawing()
        if yaw is None:
            drawing.solid("sphere", Transform(where), (_DOT_M,) * 3, _COLOR)
        else:
            turn = quaternion_from_rpy(0.0, 0.0, yaw)
            size = ArrowSize(0.35, 0.03, 0.15, 0.1)
            drawing.arrow(Transform(where, turn), size, _COLOR)
        self._canvas.show(drawing)

    def _say(self, text: str) -> None:
        self._advice.content, self._advice.visible = escaped_markdown(text), bool(text)


def _class_of(given: dict[str, Any]) -> str:
    return class_without_package(str(given.get("Class", "")))


def ground_point(origin: Vector3, direction: Vector3) -> Vector3 | None:
    """Return the point where a ray meets the plane z = 0, within 10 km; else None."""
    x, y, z = (float(part) for part in origin)
    dx, dy, dz = (float(part) for part in direction)
    # The ray points away from the plane or along it, or is not finite.
    if not z * dz < 0.0:
        return None
    way = -z / dz
    place = (x + way * dx, y + way * dy, 0.0)
    is_near = math.hypot(way * dx, way * dy, z) < _FARTHEST_M
    return place if is_near and all(map(math.isfinite, place)) else None

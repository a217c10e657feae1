"""MoveIt's ``PlanningScene``: collision objects, attached objects and the robot.

Since move_group publishes changes only, the whole scene is requested from its service first.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.interfaces import get_service
from teleopctl.node import add_type_from_graph
from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.conversions import rgba_of
from teleopctl.viewer.displays.moveit.base import MoveItDisplay, RobotOverlay
from teleopctl.viewer.displays.moveit.collision_objects import SceneObjects
from teleopctl.viewer.displays.moveit.trajectory import (
    Positions,
    invalid_positions_text,
    joint_positions_of,
)
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.scene.canvas import Canvas

if TYPE_CHECKING:
    from teleopctl.node import Client
    from teleopctl.viewer.displays.base import Stage

# Any: messages, whose classes are created from definitions at run time.

_TYPE = "moveit_msgs/srv/GetPlanningScene"
# All parts of moveit_msgs/msg/PlanningSceneComponents but the octomap, which is not drawn: state,
# attached objects, names and shapes of the world's objects, transforms, and colours of objects.
_PARTS = 2 | 4 | 8 | 16 | 64 | 512
_REQUEST_PERIOD_S = 2.0


class SceneRequest:
    """Client of ``get_planning_scene`` that repeats its request until a response arrives.

    Args:
        stage: The viewer's node.
        take: Function called on the node's thread with the received scene.
    """

    def __init__(self, stage: Stage, take: Callable[[Any], object]) -> None:
        self._stage = stage
        self._take = take
        self._wanted = False
        self._due = 0.0
        self._learning = False
        self._client: Client[Any, Any] | None = None

    def begin(self) -> None:
        """Start requesting the planning scene; `tick` sends the requests."""
        self._wanted, self._due = True, 0.0

    def end(self) -> None:
        """Stop requesting the planning scene, and destroy the client."""
        self._wanted = False
        if self._client is not None:
            self._stage.node.destroy_client(self._client)
            self._client = None

    def tick(self, service: str) -> None:
        """Send a request, every 2 s at most, if one is due and ``service`` is available.

        Args:
            service: Name of the service.
        """
        now = time.monotonic()
        if not self._wanted or now < self._due:
            return
        self._due = now + _REQUEST_PERIOD_S
        if self._learning or not self._stage.node.count_services(service):
            return
        if self._stage.knows_type(_TYPE):
            self._send(service)
        else:
            self._request_definition()

    def _request_definition(self) -> None:
        node = self._stage.node
        graph = node.graph()
        self._learning = True

        def learned(_result: object) -> None:
            # Nodes that start later may have the definition.
            self._learning = False
            if self._stage.knows_type(_TYPE):
                self._due = 0.0

        self._stage.run_in_background(lambda: add_type_from_graph(node, _TYPE, graph), learned)

    def _send(self, service: str) -> None:
        node = self._stage.node
        if self._client is not None:
            node.destroy_client(self._client)
        kind = get_service(_TYPE)
        self._client = node.create_client(kind, service)
        request = kind.Request()
        request.components.components = _PARTS
        self._client.call_async(request).add_done_callback(self._answered)

    def _answered(self, future: Any) -> None:
        if not self._wanted or future.cancelled() or future.exception() is not None:
            return
        self.end()
        self._take(future.result().scene)


SCENE_PROPERTIES = (
    Property("Move Group Namespace", "", hint="Namespace of move_group"),
    Property("Scene Geometry/Show Scene Geometry", True),
    Property("Scene Geometry/Scene Alpha", 0.9, low=0.0, high=1.0),
    Property("Scene Geometry/Scene Color", (50, 230, 50)),
    Property(
        "Scene Geometry/Show Simulated World", True, hint="Draw the bodies of the simulator's world"
    ),
    Property(
        "Scene Robot/Show Robot Visual", True, hint="Draw the robot in the state of the scene"
    ),
    Property("Scene Robot/Robot Alpha", 1.0, low=0.0, high=1.0),
    Property("Scene Robot/Attached Body Color", (150, 50, 150)),
)


class PlanningScene(MoveItDisplay):
    """MoveIt's ``PlanningScene`` display: collision objects, attached objects and the robot."""

    rviz_class = "PlanningScene"
    message_type = "moveit_msgs/msg/PlanningScene"
    topic_key = "Planning Scene Topic"
    default_topic = "/monitored_planning_scene"
    latched = True
    properties: ClassVar[tuple[Property, ...]] = SCENE_PROPERTIES

    def _prepare(self) -> None:
        super()._prepare()
        self._objects = SceneObjects()
        self._canvases: dict[str, Canvas] = {}
        self._robot: RobotOverlay | None = None
        self._state: Positions = {}
        self._left_out = 0
        self._octomap = False
        self._stale = False
        self._request = SceneRequest(self.stage, self.received)

    @property
    def robot_poses(self) -> Mapping[str, Transform]:
        """Link poses of the drawn robot in its root link's frame; empty if none is drawn."""
        return {} if self._robot is None else self._robot.poses

    def started(self) -> None:
        """Subscribe to the robot description, and start requesting the planning scene."""
        super().started()
        self._request.begin()

    def stopped(self) -> None:
        """Stop requesting the planning scene, and remove everything from the display."""
        self._request.end()
        super().stopped()

    def received(self, message: Any) -> None:
        """Apply a PlanningScene message: a whole scene, or the changes of a diff."""
        objects = self._objects
        objects.left_out = 0
        if not message.is_diff:
            self._request.end()
            objects.clear()
            self._state = {}
        self._octomap = bool(len(message.world.octomap.octomap.data)) or (
            self._octomap and message.is_diff
        )
        for one in message.world.collision_objects:
            objects.apply(one)
        for held in message.robot_state.attached_collision_objects:
            objects.apply(held.object, held.link_name)
        objects.set_colors(message.object_colors)
        objects.drop_unused_meshes()
        positions, self._left_out = joint_positions_of(message.robot_state.joint_state)
        self._state = {**self._state, **positions}
        self._stale = True
        self._draw_robot()
        self._update_status()

    def tick(self) -> None:
        """Send a due scene request, and redraw changed collision objects."""
        namespace = self.values.text("Move Group Namespace").strip("/")
        self._request.tick(f"/{namespace}/get_planning_scene".replace("//", "/"))
        if self._stale:
            self._stale = False
            self._draw()

    def redraw(self) -> None:
        """Redraw the collision objects and the robot."""
        self._stale = True
        self._remove_robot()
        self._draw_robot()
        self._update_status()

    def clear(self) -> None:
        """Remove collision objects and robot, and drop the received planning scene."""
        self._objects.clear()
        self._state = {}
        self._octomap = self._stale = False
        self._remove_robot()
        for canvas in self._canvases.values():
            canvas.remove()
        self._canvases.clear()

    def _draw(self) -> None:
        values = self.values
        alpha = values.number("Scene Geometry/Scene Alpha")
        color = rgba_of(values.color("Scene Geometry/Scene Color"), alpha)
        held = rgba_of(values.color("Scene Robot/Attached Body Color"))
        shown = values.flag("Scene Geometry/Show Scene Geometry")
        simulated = values.flag("Scene Geometry/Show Simulated World")
        drawings = self._objects.drawings(color, held, simulated=simulated) if shown else {}
        for frame in self._canvases.keys() - drawings.keys():
            self._canvases.pop(frame).remove()
        for frame, drawing in drawings.items():
            if frame not in self._canvases:
                name = frame or self.stage.frames.fixed
                path = f"{self.stage.frames.node_path(name)}{self.root}"
                self._canvases[frame] = Canvas(self.stage.scene, path, self._objects.meshes)
            self._canvases[frame].show(drawing)

    def _draw_robot(self) -> None:
        if not self._state or not self.values.flag("Scene Robot/Show Robot Visual"):
            return
        if self._robot is None:
            alpha = self.values.number("Scene Robot/Robot Alpha")
            self._robot = self.add_overlay("scene", alpha)
        if self._robot is not None:
            self._robot.set_positions(self._state)

    def _remove_robot(self) -> None:
        if self._robot is not None:
            self._robot.remove()
            self._robot = None

    def _update_status(self) -> None:
        count = len(self._objects.by_id)
        said = "1 object" if count == 1 else f"{count} objects"
        left_out = []
        if self._objects.left_out:
            left_out.append(f"{self._objects.left_out} shapes cannot be drawn")
        if self._octomap:
            left_out.append("its octomap is not drawn")
        if self._left_out:
            left_out.append(invalid_positions_text(self._left_out))
        if left_out:
            self.set_status(WARN, f"{said}; {' and '.join(left_out)}")
        elif self.messages:
            self.set_status(OK, said)

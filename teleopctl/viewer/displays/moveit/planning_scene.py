"""``PlanningScene``: the world as MoveIt believes it to be, and the robot in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import OK, WARN
from teleopctl.viewer.displays.moveit.base import MoveItDisplay
from teleopctl.viewer.displays.moveit.collision_objects import SceneObjects
from teleopctl.viewer.displays.moveit.ghost import RobotOverlay
from teleopctl.viewer.displays.moveit.scene_request import SceneRequest
from teleopctl.viewer.displays.moveit.states import Positions, left_out_text, positions_in
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import rgba_of
from teleopctl.viewer.scene.canvas import Canvas

# Any stands for messages throughout: their classes are made at run time, from definitions.

SCENE_PROPERTIES = (
    Property("Move Group Namespace", "", hint="Of the node that knows the whole scene"),
    Property("Scene Geometry/Show Scene Geometry", True),
    Property("Scene Geometry/Scene Alpha", 0.9, low=0.0, high=1.0),
    Property("Scene Geometry/Scene Color", (50, 230, 50)),
    Property("Scene Robot/Show Robot Visual", True, hint="Draw the robot as MoveIt knows it"),
    Property("Scene Robot/Robot Alpha", 1.0, low=0.0, high=1.0),
    Property("Scene Robot/Attached Body Color", (150, 50, 150)),
)


class PlanningScene(MoveItDisplay):
    """Display of a planning scene: collision objects, attached objects and the robot."""

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
        self._request = SceneRequest(self.stage, self._take)

    @property
    def robot_poses(self) -> Mapping[str, Transform]:
        """Poses of the links of the scene's robot, in its root's frame; empty while hidden."""
        return {} if self._robot is None else self._robot.poses

    def started(self) -> None:
        """Request the full scene, since only changes are published."""
        super().started()
        self._request.begin()

    def stopped(self) -> None:
        """Remove everything from the scene."""
        self._request.end()
        super().stopped()

    def received(self, message: Any) -> None:
        """Apply a full planning scene or a difference."""
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
            objects.take(one)
        for held in message.robot_state.attached_collision_objects:
            objects.take(held.object, held.link_name)
        objects.paint(message.object_colors)
        objects.forget_unused_meshes()
        positions, self._left_out = positions_in(message.robot_state.joint_state)
        self._state = {**self._state, **positions}
        self._stale = True
        self._stand()
        self._tell()

    def tick(self) -> None:
        """Redraw what has changed."""
        namespace = self.values.text("Move Group Namespace").strip("/")
        self._request.tick(f"/{namespace}/get_planning_scene".replace("//", "/"))
        if self._stale:
            self._stale = False
            self._draw()

    def described(self) -> None:
        """Redraw everything for a new robot description."""
        self._stale = True
        self._remove_robot()
        self._stand()
        self._tell()

    def cleared(self) -> None:
        """Remove everything from the scene."""
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
        drawings = self._objects.drawings(color, held) if shown else {}
        for frame in self._canvases.keys() - drawings.keys():
            self._canvases.pop(frame).remove()
        for frame, drawing in drawings.items():
            if frame not in self._canvases:
                name = frame or self.stage.frames.fixed
                path = f"{self.stage.frames.node_of(name)}{self.root}"
                self._canvases[frame] = Canvas(self.stage.scene, path, self._objects.meshes)
            self._canvases[frame].show(drawing)

    def _stand(self) -> None:
        if not self._state or not self.values.flag("Scene Robot/Show Robot Visual"):
            return
        if self._robot is None:
            alpha = self.values.number("Scene Robot/Robot Alpha")
            self._robot = self.make_ghost("scene", alpha)
        if self._robot is not None:
            self._robot.stand(self._state)

    def _remove_robot(self) -> None:
        if self._robot is not None:
            self._robot.remove()
            self._robot = None

    def _tell(self) -> None:
        count = len(self._objects.by_id)
        said = "1 object" if count == 1 else f"{count} objects"
        left_out = []
        if self._objects.left_out:
            left_out.append(f"{self._objects.left_out} shapes cannot be drawn")
        if self._octomap:
            left_out.append("its octomap is not drawn")
        if self._left_out:
            left_out.append(left_out_text(self._left_out))
        if left_out:
            self.say(WARN, f"{said}; {' and '.join(left_out)}")
        elif self.messages:
            self.say(OK, said)

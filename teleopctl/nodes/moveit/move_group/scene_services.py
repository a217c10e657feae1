"""Planning scene on topics and services: ``get_planning_scene`` and so on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import CollisionScene
from teleopctl.nodes.moveit.move_group import messages
from teleopctl.nodes.moveit.move_group.context import MoveGroupContext
from teleopctl.nodes.moveit.move_group.parameters import setting

# Bits of moveit_msgs/msg/PlanningSceneComponents.
_SETTINGS, _STATE, _ATTACHED, _NAMES, _GEOMETRY = 1, 2, 4, 8, 16
_TRANSFORMS, _ALLOWED, _PADDING, _COLORS = 64, 128, 256, 512
_ALL = 0xFFFFFFFF
_DEPTH = 100
# Rate of the robot's state on ``monitored_planning_scene``, as in MoveIt.
_DEFAULT_RATE_HZ = 4.0

# Any, here and below: message classes are generated at run time from definitions.
_PlanningScene: Any = get_message("moveit_msgs/msg/PlanningScene")


class SceneServices:
    """Topics and services by which clients read and change the planning scene.

    Args:
        context: Robot, state and scene.
    """

    def __init__(self, context: MoveGroupContext) -> None:
        self._context, node = context, context.node
        self._log = node.get_logger()
        self._published: dict[str, object] = {}
        self._published_attached: dict[str, object] = {}
        self._published_state: dict[str, float] = {}
        node.create_service(
            get_service("moveit_msgs/srv/GetPlanningScene"), "get_planning_scene", self._get
        )
        node.create_service(
            get_service("moveit_msgs/srv/ApplyPlanningScene"), "apply_planning_scene", self._apply
        )
        for type_name, topic, callback in (
            ("moveit_msgs/msg/PlanningScene", "planning_scene", self._on_scene),
            ("moveit_msgs/msg/PlanningSceneWorld", "planning_scene_world", self._on_world),
            ("moveit_msgs/msg/CollisionObject", "collision_object", self._on_object),
            (
                "moveit_msgs/msg/AttachedCollisionObject",
                "attached_collision_object",
                self._on_attached,
            ),
        ):
            node.create_subscription(get_message(type_name), topic, callback, _DEPTH)
        self._publisher = node.create_publisher(_PlanningScene, "monitored_planning_scene", _DEPTH)
        context.when_scene_changed(self._publish_changes)
        self._publisher.publish(self.message(_ALL))
        rate = float(setting(node, "publish_planning_scene_hz", _DEFAULT_RATE_HZ))
        period_s = 1.0 / (rate if rate > 0.0 else _DEFAULT_RATE_HZ)
        self._timer = node.create_timer(period_s, self._publish_state)

    # --- out ------------------------------------------------------------------------------------

    def message(self, components: int) -> Any:
        """Return the scene as a PlanningScene message.

        Args:
            components: Bits of ``moveit_msgs/msg/PlanningSceneComponents``.
        """
        context = self._context
        message = _PlanningScene(is_diff=False)
        with context.lock:
            positions = context.positions()
            scene = context.scene
            message.name, message.robot_model_name = scene.name, scene.model.description.name
            if components & _STATE:
                message.robot_state = messages.write_robot_state(positions, context.planning_frame)
            if components & _ATTACHED:
                message.robot_state.attached_collision_objects = [
                    messages.write_attached(one) for one in scene.attached.values()
                ]
            if components & _TRANSFORMS:
                message.fixed_frame_transforms = [self._own_transform()]
            if components & _ALLOWED:
                message.allowed_collision_matrix = messages.write_allowed(scene.allowed)
            if components & _PADDING:
                self._write_padding(message, scene)
            if components & _COLORS:
                message.object_colors = [self._color(name) for name in scene.colors]
            if components & (_NAMES | _GEOMETRY):
                message.world.collision_objects = [
                    messages.write_object(
                        one,
                        context.planning_frame,
                        with_shapes=bool(components & _GEOMETRY),
                    )
                    for one in scene.objects.values()
                ]
        return message

    def _get(self, request: Any, response: Any) -> Any:
        response.scene = self.message(int(request.components.components) or _ALL)
        return response

    def _own_transform(self) -> Any:
        transform: Any = get_message("geometry_msgs/msg/TransformStamped")()
        transform.header.frame_id = transform.child_frame_id = self._context.planning_frame
        return transform

    def _write_padding(self, message: Any, scene: CollisionScene) -> None:
        padding: Any = get_message("moveit_msgs/msg/LinkPadding")
        scale: Any = get_message("moveit_msgs/msg/LinkScale")
        for link in scene.model.links:
            message.link_padding.append(
                padding(link_name=link, padding=scene.padding_m.get(link, 0.0))
            )
            message.link_scale.append(scale(link_name=link, scale=scene.scale.get(link, 1.0)))

    def _color(self, name: str) -> Any:
        message: Any = get_message("moveit_msgs/msg/ObjectColor")(id=name)
        color = message.color
        color.r, color.g, color.b, color.a = self._context.scene.colors[name]
        return message

    def _publish_changes(self) -> None:
        """Publish what has changed of objects and attached objects since the last time."""
        context, scene = self._context, self._context.scene
        with context.lock:
            message = _PlanningScene(
                is_diff=True, name=scene.name, robot_model_name=scene.model.description.name
            )
            message.robot_state.is_diff = True
            frame = context.planning_frame
            for name, one in scene.objects.items():
                if self._published.get(name) is not one:
                    message.world.collision_objects.append(messages.write_object(one, frame))
            for name in self._published.keys() - scene.objects.keys():
                gone: Any = get_message("moveit_msgs/msg/CollisionObject")(
                    id=name, operation=bytes([messages.REMOVE])
                )
                gone.header.frame_id = frame
                message.world.collision_objects.append(gone)
            for name, held in scene.attached.items():
                if self._published_attached.get(name) is not held:
                    message.robot_state.attached_collision_objects.append(
                        messages.write_attached(held)
                    )
            for name in self._published_attached.keys() - scene.attached.keys():
                gone = get_message("moveit_msgs/msg/AttachedCollisionObject")()
                gone.object.id, gone.object.operation = name, bytes([messages.REMOVE])
                message.robot_state.attached_collision_objects.append(gone)
            message.allowed_collision_matrix = messages.write_allowed(scene.allowed)
            message.object_colors = [self._color(name) for name in scene.colors]
            self._published = dict(scene.objects)
            self._published_attached = dict(scene.attached)
        self._publisher.publish(message)

    def _publish_state(self) -> None:
        """Publish the robot's state if it has changed and the topic has subscribers."""
        if not self._publisher.get_subscription_count():
            return
        context = self._context
        with context.lock:
            positions = context.positions()
            if positions == self._published_state:
                return
            self._published_state = positions
            message = _PlanningScene(
                is_diff=True,
                name=context.scene.name,
                robot_model_name=context.scene.model.description.name,
            )
            message.robot_state = messages.write_robot_state(positions, context.planning_frame)
        message.robot_state.is_diff = True
        self._publisher.publish(message)

    # --- in -------------------------------------------------------------------------------------

    def _apply(self, request: Any, response: Any) -> Any:
        response.success = self._on_scene(request.scene)
        return response

    def _on_scene(self, message: Any) -> bool:
        context = self._context
        problems: list[str] = []
        failed = self._try(lambda: problems.extend(context.apply_scene(context.scene, message)))
        for problem in problems:
            self._log.error(f"Planning scene: {problem}")
        return not failed and not problems

    def _on_world(self, message: Any) -> None:
        scene = _PlanningScene(is_diff=True, world=message)
        scene.robot_state.is_diff = True
        self._on_scene(scene)

    def _on_object(self, message: Any) -> None:
        context = self._context
        self._try(lambda: context.apply_object(context.scene, message))

    def _on_attached(self, message: Any) -> None:
        context = self._context
        self._try(lambda: context.apply_attached(context.scene, message))

    def _try(self, change: Callable[[], object]) -> str:
        """Change, compile and publish the scene; return and log what is wrong."""
        context = self._context
        problem = ""
        with context.lock:
            before = context.scene.copy()
            try:
                change()
                context.scene.compiled()
            except TeleopctlError as error:
                problem = f"{error.message} ({error.hint})" if error.hint else error.message
                self._log.error(problem)
                context.scene.restore(before)
        context.scene_changed()
        return problem

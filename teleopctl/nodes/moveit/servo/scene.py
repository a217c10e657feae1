"""The planning scene of a move_group, as obstacles for servo."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import CompiledScene, KinematicModel, RobotGroups
from teleopctl.node import Node

if TYPE_CHECKING:
    from teleopctl.nodes.moveit.move_group.context import MoveGroupContext

_TOPIC, _SERVICE = "monitored_planning_scene", "get_planning_scene"
_DEPTH = 100
# Bits of moveit_msgs/msg/PlanningSceneComponents: attached objects, names and shapes of objects,
# allowed collisions, padding.
_COMPONENTS = 4 | 8 | 16 | 128 | 256

# Any, here and below: message classes are generated at run time from definitions.


class SceneFollower:
    """Subscriber of the planning scene of a ``move_group``, which compiles it after each change.

    Args:
        node: Node of the endpoints.
        model: Model of the robot, for this class alone.
        groups: Groups of the robot.
        on_scene: Called on a thread with each new scene.
    """

    def __init__(
        self,
        node: Node,
        model: KinematicModel,
        groups: RobotGroups,
        on_scene: Callable[[CompiledScene], object],
    ) -> None:
        self._node, self._model, self._groups, self._on_scene = node, model, groups, on_scene
        self._context: MoveGroupContext | None = None
        self._changed = threading.Condition()
        self._is_dirty = False
        self._thread: threading.Thread | None = None
        node.create_subscription(
            get_message("moveit_msgs/msg/PlanningScene"), _TOPIC, self._on_message, _DEPTH
        )
        kind = get_service("moveit_msgs/srv/GetPlanningScene")
        self._client = node.create_client(kind, _SERVICE)
        if self._client.service_is_ready():
            request = kind.Request()
            request.components.components = _COMPONENTS
            self._client.call_async(request).add_done_callback(self._on_whole)

    # Any: the future of a response.
    def _on_whole(self, future: Any) -> None:
        if (response := future.result()) is not None:
            self._on_message(response.scene)

    def _on_message(self, message: Any) -> None:
        says_something = (
            message.world.collision_objects
            or message.robot_state.attached_collision_objects
            or message.allowed_collision_matrix.entry_names
            or message.link_padding
            or message.link_scale
        )
        if not says_something and message.is_diff:
            return  # the robot's state alone
        if self._context is None:
            from teleopctl.nodes.moveit.move_group.context import MoveGroupContext

            self._context = MoveGroupContext(self._node, self._model, self._groups)
        context = self._context
        with context.lock:
            problems = context.apply_scene(context.scene, message)
        for problem in problems:
            self._node.get_logger().warning(f"The planning scene: {problem}")
        with self._changed:
            self._is_dirty = True
            if self._thread is None:
                self._thread = threading.Thread(target=self._compile, args=(context,), daemon=True)
                self._thread.start()

    def _compile(self, context: MoveGroupContext) -> None:
        """Compile the scene until it is that of the last message."""
        while True:
            with self._changed:
                if not self._is_dirty:
                    self._thread = None
                    return
                self._is_dirty = False
            with context.lock:
                scene = context.scene.copy()
            try:
                self._on_scene(scene.compile())
            except TeleopctlError as error:
                self._node.get_logger().error(
                    f"Servo keeps the previous planning scene: {error.message}"
                )

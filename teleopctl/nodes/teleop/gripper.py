"""Commands to a gripper, by whichever active controller moves it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from teleopctl.interfaces import from_seconds, get_action, get_message, set_stamp
from teleopctl.node import ActionClient, Node
from teleopctl.nodes.moveit.servo.outputs import (
    TRAJECTORY_TYPE,
    ControllerWatch,
    Target,
    choose_targets,
)

_DEPTH = 10
# Speed of a gripper that has no velocity limit, and part of the limit that is used.
_DEFAULT_SPEED, _SPEED_PART = 1.0, 0.5
_SHORTEST_S = 0.2
# Largest effort, N m or N, of a gripper action; 0 would be none.
_MAX_EFFORT = 0.0

# Any, here and below: message classes are generated at run time from definitions.


class GripperCommander:
    """Moves a gripper's joint by its action, its trajectory controller or its command topic.

    Args:
        node: Node of the endpoints.
        joint: The gripper's independent joint.
        velocity: Its velocity limit, rad/s or m/s.
    """

    def __init__(self, node: Node, joint: str, velocity: float) -> None:
        self._node, self._joint = node, joint
        self._speed = _SPEED_PART * velocity if velocity < float("inf") else _DEFAULT_SPEED
        self._target: Target | None = None
        self._publisher: Any = None
        self._actions: dict[str, ActionClient[Any, Any, Any]] = {}
        self._action: tuple[str, str] | None = None
        self._watch = ControllerWatch(node, self._on_controllers)
        self._watch.query()

    @property
    def is_available(self) -> bool:
        """Whether an active controller moves the gripper."""
        return self._action is not None or self._target is not None

    def move(self, position: float, measured: Mapping[str, float]) -> bool:
        """Command a position, rad or m; return False if no active controller takes it.

        Args:
            position: The position.
            measured: Measured positions of all joints.
        """
        if self._action is not None:
            self._send_goal(*self._action, position)
        elif self._target is not None:
            self._publish(self._target, position, measured)
        else:
            self._watch.query()
            return False
        return True

    def _on_controllers(self, controllers: list[Any], namespace: str) -> None:
        self._action = None
        for controller in controllers:
            claims = {name.rpartition("/")[0] for name in controller.claimed_interfaces}
            if controller.state != "active" or self._joint not in claims:
                continue
            kind = controller.type.rpartition("/")[2]
            name = f"{namespace.rstrip('/')}/{controller.name}/gripper_cmd"
            if "parallel_gripper" in controller.type:
                self._action = (name, "control_msgs/action/ParallelGripperCommand")
            elif kind.endswith(("GripperActionController", "GripperController")):
                self._action = (name, "control_msgs/action/GripperCommand")
        targets = choose_targets(controllers, [self._joint], namespace)
        target = targets[0] if targets else None
        if target == self._target:
            return
        if self._publisher is not None:
            self._node.destroy_publisher(self._publisher)
            self._publisher = None
        self._target = target
        if target is not None:
            kind = (
                "trajectory_msgs/msg/JointTrajectory"
                if target.type == TRAJECTORY_TYPE
                else "std_msgs/msg/Float64MultiArray"
            )
            self._publisher = self._node.create_publisher(get_message(kind), target.topic, _DEPTH)

    def _send_goal(self, name: str, type_name: str, position: float) -> None:
        kind: Any = get_action(type_name)
        client = self._actions.get(name)
        if client is None:
            client = self._actions[name] = ActionClient(self._node, kind, name)
        goal = kind.Goal()
        if type_name.endswith("ParallelGripperCommand"):
            goal.command.name, goal.command.position = [self._joint], [position]
        else:
            goal.command.position, goal.command.max_effort = position, _MAX_EFFORT
        client.send_goal_async(goal)

    def _publish(self, target: Target, position: float, measured: Mapping[str, float]) -> None:
        wanted = {
            **{name: measured.get(name, 0.0) for name in target.joints},
            self._joint: position,
        }
        if target.type != TRAJECTORY_TYPE:
            message: Any = get_message("std_msgs/msg/Float64MultiArray")()
            message.data = [wanted[name] for name in target.joints]
        else:
            point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")()
            point.positions = [wanted[name] for name in target.joints]
            way = abs(position - measured.get(self._joint, position))
            set_stamp(point.time_from_start, from_seconds(max(_SHORTEST_S, way / self._speed)))
            message = get_message("trajectory_msgs/msg/JointTrajectory")()
            message.joint_names, message.points = list(target.joints), [point]
        self._publisher.publish(message)

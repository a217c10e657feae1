"""The controllers that execute trajectories: what they are, and one goal of each."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionClient, Node
from teleopctl.nodes.moveit.move_group.parameters import setting

TRAJECTORY, GRIPPER, PARALLEL_GRIPPER = (
    "FollowJointTrajectory",
    "GripperCommand",
    "ParallelGripperCommand",
)
_ACTIONS = {
    TRAJECTORY: "control_msgs/action/FollowJointTrajectory",
    GRIPPER: "control_msgs/action/GripperCommand",
    PARALLEL_GRIPPER: "control_msgs/action/ParallelGripperCommand",
}
_PREFIX = "moveit_simple_controller_manager"
# Time to wait for an answer of a manager or a controller, s.
_ANSWER_S = 5.0
_SERVER_S = 1.0

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True)
class Controller:
    """Controller that moves joints by an action.

    Attributes:
        name: Name of the controller.
        action: Name of the action.
        type: Kind of action, as in ``moveit_controllers.yaml``.
        joints: Joints that it moves.
        is_default: Whether it is preferred to others that move the same joints.
        max_effort: Largest effort of a gripper, N or N m.
    """

    name: str
    action: str
    type: str
    joints: tuple[str, ...]
    is_default: bool = False
    max_effort: float = 0.0


class Controllers:
    """Controllers of ``moveit_controllers.yaml`` and of the running controller manager.

    Args:
        node: Node of the clients.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.configured = configured_controllers(node)
        namespace = node.get_namespace().rstrip("/")
        self._namespace = namespace
        self._list: Any = node.create_client(
            get_service("controller_manager_msgs/srv/ListControllers"),
            f"{namespace}/controller_manager/list_controllers",
        )
        self._clients: dict[tuple[str, str], ActionClient[Any, Any, Any]] = {}

    def available(self) -> list[Controller]:
        """Return the controllers that can be used now: configured ones that run, else all active.

        Blocks until the controller manager has answered.
        """
        ready = [one for one in self.configured if self.client(one).server_is_ready()]
        if ready:
            return ready
        return self._active()

    def client(self, controller: Controller) -> ActionClient[Any, Any, Any]:
        """Return the client of a controller's action."""
        key = (controller.action, controller.type)
        if key not in self._clients:
            self._clients[key] = ActionClient(
                self._node, get_action(_ACTIONS[controller.type]), controller.action
            )
        return self._clients[key]

    def _active(self) -> list[Controller]:
        if not self._list.wait_for_service(timeout_sec=_SERVER_S):
            return []
        future = self._list.call_async(
            get_service("controller_manager_msgs/srv/ListControllers").Request()
        )
        if not future.wait(_ANSWER_S) or (response := future.result()) is None:
            return []
        return list(active_controllers(response.controller, self._namespace))


def configured_controllers(node: Node) -> list[Controller]:
    """Return the controllers of the parameters ``moveit_simple_controller_manager``."""

    # Any: the value of a parameter.
    def value(name: str, default: bool | float | str | list[str]) -> Any:
        return setting(node, f"{_PREFIX}.{name}", default)

    controllers = []
    log = node.get_logger()
    for name in value("controller_names", []):
        namespace, kind = value(f"{name}.action_ns", ""), value(f"{name}.type", "")
        joints = tuple(value(f"{name}.joints", []))
        if kind not in _ACTIONS or not joints:
            log.error(
                f"Controller '{name}' of {_PREFIX} has the type '{kind}' and the joints "
                f"{list(joints)}: it needs joints and one of {', '.join(_ACTIONS)}"
            )
            continue
        command = value(f"{name}.command_joint", "")
        if kind == GRIPPER and command:
            joints = (command, *(joint for joint in joints if joint != command))
        controllers.append(
            Controller(
                name,
                f"{name}/{namespace}" if namespace else name,
                kind,
                joints,
                bool(value(f"{name}.default", default=False)),
                float(value(f"{name}.max_effort", 0.0)),
            )
        )
    return controllers


def active_controllers(states: Iterable[Any], namespace: str) -> Iterable[Controller]:
    """Yield the active controllers with an action, of ``ControllerState`` messages."""
    for state in states:
        if state.state != "active":
            continue
        claimed = (name.rpartition("/")[0] for name in state.claimed_interfaces)
        joints = tuple(dict.fromkeys(joint for joint in claimed if joint))
        kind = state.type.rpartition("/")[2]
        base = f"{namespace}/{state.name}"
        if kind == "JointTrajectoryController":
            yield Controller(state.name, f"{base}/follow_joint_trajectory", TRAJECTORY, joints)
        elif "parallel_gripper" in state.type:
            yield Controller(state.name, f"{base}/gripper_cmd", PARALLEL_GRIPPER, joints)
        elif kind.endswith(("GripperActionController", "GripperController")):
            yield Controller(state.name, f"{base}/gripper_cmd", GRIPPER, joints)


def choose_controllers(
    joints: Sequence[str], controllers: Sequence[Controller], named: Sequence[str] = ()
) -> tuple[list[Controller], list[str]]:
    """Return the controllers that move joints together, and the joints that none moves.

    Args:
        joints: Joints to move.
        controllers: Controllers to choose from.
        named: Names of the only controllers that may be chosen; empty for all.
    """
    allowed = [one for one in controllers if not named or one.name in named]
    # Defaults first, then those that move the most of the joints.
    allowed.sort(key=lambda one: (not one.is_default, -len({*one.joints} & {*joints})))
    chosen: list[Controller] = []
    left = list(joints)
    for one in allowed:
        if {*one.joints} & {*left}:
            chosen.append(one)
            left = [joint for joint in left if joint not in one.joints]
    return chosen, left


def goal_for(controller: Controller, trajectory: Any, measured: Mapping[str, float]) -> Any:
    """Return the part of a JointTrajectory that a controller executes, as a goal of its action.

    Joints of a trajectory controller that the trajectory does not move stay where they are.

    Args:
        controller: The controller.
        trajectory: A ``trajectory_msgs/msg/JointTrajectory``.
        measured: Measured positions of all joints.
    """
    goal: Any = get_action(_ACTIONS[controller.type]).Goal()
    names = list(trajectory.joint_names)
    last = trajectory.points[-1]
    if controller.type != TRAJECTORY:
        joint = next(name for name in controller.joints if name in names)
        position = float(last.positions[names.index(joint)])
        if controller.type == GRIPPER:
            goal.command.position, goal.command.max_effort = position, controller.max_effort
        else:
            goal.command.name, goal.command.position = [joint], [position]
            if controller.max_effort:
                goal.command.effort = [controller.max_effort]
        return goal
    joints = list(controller.joints)
    places = [names.index(name) if name in names else -1 for name in joints]
    goal.trajectory.header.frame_id = trajectory.header.frame_id
    goal.trajectory.joint_names = joints
    point_type: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    for point in trajectory.points:
        made = point_type(time_from_start=point.time_from_start)
        made.positions = [
            float(point.positions[place]) if place >= 0 else measured.get(name, 0.0)
            for name, place in zip(joints, places, strict=True)
        ]
        for quantity in ("velocities", "accelerations"):
            values = getattr(point, quantity)
            if len(values):
                picked = [float(values[place]) if place >= 0 else 0.0 for place in places]
                setattr(made, quantity, picked)
        goal.trajectory.points.append(made)
    return goal


class RunningGoal:
    """Goal of a controller that is sent, until its end.

    Args:
        client: Client of the controller's action.
        controller: The controller.
        goal: The goal.
        on_end: Called once the goal has ended.

    Attributes:
        controller: The controller.
        problem: Why it failed, as a sentence; empty if it did not.
        ended: Whether it has ended.
        canceled: Whether it ended since it was canceled.
    """

    def __init__(
        self,
        client: ActionClient[Any, Any, Any],
        controller: Controller,
        goal: Any,
        on_end: Callable[[], object],
    ) -> None:
        self.controller = controller
        self.problem = ""
        self.ended = self.canceled = False
        self._on_end = on_end
        self._handle: Any = None
        self._is_canceling = False
        self._lock = threading.Lock()
        client.send_goal_async(goal).add_done_callback(self._accepted)

    def cancel(self) -> None:
        """Let the controller stop its joints."""
        with self._lock:
            self._is_canceling = True
            handle = self._handle
        if handle is not None and not self.ended:
            handle.cancel_goal_async()

    # Any: futures of handles and results.
    def _accepted(self, future: Any) -> None:
        handle = future.result()
        if handle is None or not handle.accepted:
            self._end(f"Controller '{self.controller.name}' rejected the trajectory")
            return
        with self._lock:
            self._handle = handle
            is_canceling = self._is_canceling
        handle.get_result_async().add_done_callback(self._finished)
        if is_canceling:
            handle.cancel_goal_async()

    def _finished(self, future: Any) -> None:
        response = future.result()
        succeeded, canceled = 4, 5
        if response is None:
            self._end(f"Controller '{self.controller.name}' did not answer")
            return
        if response.status == canceled:
            self.canceled = True
            self._end("")
            return
        result = response.result
        code = int(getattr(result, "error_code", 0))
        if response.status == succeeded and code == 0:
            self._end("")
            return
        text = getattr(result, "error_string", "") or f"error code {code}"
        self._end(f"Controller '{self.controller.name}' failed: {text}")

    def _end(self, problem: str) -> None:
        self.problem, self.ended = problem, True
        self._on_end()

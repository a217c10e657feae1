"""Active controllers that command joints: what each takes, and which ones move a set of joints."""

from __future__ import annotations

import enum
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionClient, Node, qos_profile_latched

_LIST = "controller_manager_msgs/srv/ListControllers"
# Time to wait for the manager's service, and for its answer, s.
_SERVER_S, _ANSWER_S = 1.0, 5.0

# Any, here and below: message classes are generated at run time from definitions.


class ActionKind(enum.StrEnum):
    """Action of a controller, by its name in ``moveit_controllers.yaml``."""

    TRAJECTORY = "FollowJointTrajectory"
    GRIPPER = "GripperCommand"
    PARALLEL_GRIPPER = "ParallelGripperCommand"

    @property
    def type_name(self) -> str:
        """Type of the action."""
        return f"control_msgs/action/{self.value}"


class StreamKind(enum.StrEnum):
    """Type of the messages on a controller's command topic, as in servo's ``command_out_type``."""

    TRAJECTORY = "trajectory_msgs/JointTrajectory"
    ARRAY = "std_msgs/Float64MultiArray"


@dataclass(frozen=True, slots=True)
class CommandTopic:
    """Topic of a controller that takes a stream of joint commands.

    Attributes:
        topic: Full name of the topic.
        kind: Type of its messages.
        joints: Joints that a message commands, in its order.
        quantity: ``position`` or ``velocity``, for arrays.
    """

    topic: str
    kind: StreamKind
    joints: tuple[str, ...]
    quantity: str = "position"


@dataclass(frozen=True, slots=True)
class Controller:
    """Controller that moves joints, by an action, by a topic, or by both.

    Attributes:
        name: Name of the controller.
        joints: Joints that it moves.
        action: Name of its action; empty if it has none.
        kind: Kind of the action.
        stream: Its command topic; None if it has none.
        is_default: Whether it is preferred to others that move the same joints.
        max_effort: Largest effort of a gripper, N or N m; 0 for what it has.
    """

    name: str
    joints: tuple[str, ...]
    action: str = ""
    kind: ActionKind = ActionKind.TRAJECTORY
    stream: CommandTopic | None = None
    is_default: bool = False
    max_effort: float = 0.0

    def __str__(self) -> str:
        return f"{self.name} ({', '.join(self.joints)})"


def active_controllers(states: Iterable[Any], namespace: str) -> list[Controller]:
    """Return the active controllers that claim joints, in the order of the manager.

    A controller that others command (in chained mode) takes no commands of its own; those that
    command it move its joints.

    Args:
        states: ``controller_manager_msgs/msg/ControllerState`` of all controllers.
        namespace: Namespace of the controllers, such as ``/``.
    """
    found = []
    active = [state for state in states if state.state == "active"]
    names = {state.name for state in active}
    for state in active:
        claimed = [_own_name(name, names).rpartition("/") for name in state.claimed_interfaces]
        joints = tuple(dict.fromkeys(joint for joint, _, _ in claimed if joint))
        if not joints or state.is_chained:
            continue
        quantities = {quantity for _, _, quantity in claimed}
        base = f"{namespace.rstrip('/')}/{state.name}"
        package, _, kind = state.type.rpartition("/")
        if kind == "JointTrajectoryController":
            topic = CommandTopic(f"{base}/joint_trajectory", StreamKind.TRAJECTORY, joints)
            action = f"{base}/follow_joint_trajectory"
            found.append(Controller(state.name, joints, action, stream=topic))
        elif kind.endswith(("GripperActionController", "GripperController")):
            is_parallel = "parallel_gripper" in package
            found.append(
                Controller(
                    state.name,
                    joints,
                    f"{base}/gripper_cmd",
                    ActionKind.PARALLEL_GRIPPER if is_parallel else ActionKind.GRIPPER,
                )
            )
        elif len(quantities) == 1 and quantities <= {"position", "velocity"}:
            (quantity,) = quantities
            topic = CommandTopic(f"{base}/commands", StreamKind.ARRAY, joints, quantity)
            found.append(Controller(state.name, joints, stream=topic))
        else:
            found.append(Controller(state.name, joints))
    return found


def _own_name(interface: str, controllers: Collection[str]) -> str:
    """Return the name of a claimed interface without the controller that offers it, if one does."""
    first, _, rest = interface.partition("/")
    return rest if first in controllers else interface


def choose_streams(controllers: Iterable[Controller], joints: Sequence[str]) -> list[CommandTopic]:
    """Return the command topics of controllers that together move joints.

    Args:
        controllers: Controllers to choose from.
        joints: Joints to move.

    Returns:
        The topics; empty if a joint has no controller with one.
    """
    found: dict[str, CommandTopic] = {}
    for controller in controllers:
        for joint in controller.joints:
            if controller.stream is not None:
                found.setdefault(joint, controller.stream)
    if any(joint not in found for joint in joints):
        return []
    return list(dict.fromkeys(found[joint] for joint in joints))


def choose_controllers(
    joints: Sequence[str], controllers: Iterable[Controller], named: Sequence[str] = ()
) -> tuple[list[Controller], list[str]]:
    """Return the controllers whose actions move joints together, and the joints that none moves.

    Args:
        joints: Joints to move.
        controllers: Controllers to choose from.
        named: Names of the only controllers that may be chosen; empty for all.
    """
    allowed = [one for one in controllers if one.action and (not named or one.name in named)]
    # Defaults first, then those that move the most of the joints.
    allowed.sort(key=lambda one: (not one.is_default, -len({*one.joints} & {*joints})))
    chosen: list[Controller] = []
    left = list(joints)
    for one in allowed:
        if {*one.joints} & {*left}:
            chosen.append(one)
            left = [joint for joint in left if joint not in one.joints]
    return chosen, left


def listed(controllers: Iterable[Controller]) -> str:
    """Return the names of controllers with their joints, for messages."""
    return "; ".join(map(str, controllers)) or "none"


class Controllers:
    """Controllers of the manager in a node's namespace, and clients of their actions.

    Args:
        node: Node of the endpoints.
        on_change: Called with the active controllers after each request, and after each change that
            the manager publishes; None to request them by `available` only.
        configured: Controllers that are used instead of the active ones while their actions are
            offered.
    """

    def __init__(
        self,
        node: Node,
        on_change: Callable[[list[Controller]], object] | None = None,
        configured: Sequence[Controller] = (),
    ) -> None:
        self._node, self._on_change = node, on_change
        self.configured = configured
        self._namespace = node.get_namespace()
        manager = f"{self._namespace.rstrip('/')}/controller_manager"
        self._kind: Any = get_service(_LIST)
        self._list: Any = node.create_client(self._kind, f"{manager}/list_controllers")
        self._clients: dict[tuple[str, str], ActionClient[Any, Any, Any]] = {}
        self._is_pending = False
        if on_change is not None:
            # Published by managers since Jazzy; older ones get a service request when needed.
            node.create_subscription(
                get_message("controller_manager_msgs/msg/ControllerManagerActivity"),
                f"{manager}/activity",
                lambda _: self.request(),
                qos_profile_latched,
            )

    def request(self) -> None:
        """Request the controllers, unless a request is pending or the service is missing."""
        if self._is_pending or not self._list.service_is_ready():
            return
        self._is_pending = True
        future = self._list.call_async(self._kind.Request())
        future.add_done_callback(self._answered)
        # The manager ended before it responded: request from the next one.
        future.on_unanswered(self._forget_request)

    def available(self) -> list[Controller]:
        """Return the controllers that can be used now: configured ones that run, else all active.

        Blocks until the controller manager has answered; without one the list is empty.
        """
        ready = [one for one in self.configured if self.client(one).server_is_ready()]
        if ready:
            return ready
        if not self._list.wait_for_service(timeout_sec=_SERVER_S):
            return []
        future = self._list.call_async(self._kind.Request())
        if not future.wait(_ANSWER_S) or (response := future.result()) is None:
            return []
        return active_controllers(response.controller, self._namespace)

    def client(self, controller: Controller) -> ActionClient[Any, Any, Any]:
        """Return the client of a controller's action."""
        key = (controller.action, controller.kind.value)
        if key not in self._clients:
            kind = get_action(controller.kind.type_name)
            self._clients[key] = ActionClient(self._node, kind, controller.action)
        return self._clients[key]

    def _forget_request(self) -> None:
        self._is_pending = False

    # Any: the future of a response.
    def _answered(self, future: Any) -> None:
        self._is_pending = False
        response = None if future.exception() is not None else future.result()
        if response is not None and self._on_change is not None:
            self._on_change(active_controllers(response.controller, self._namespace))

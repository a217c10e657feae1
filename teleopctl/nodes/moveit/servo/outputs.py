"""Outputs of servo: the active controllers that command the group's joints, and their topics."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from teleopctl.interfaces import from_seconds, get_message, get_service, set_stamp
from teleopctl.node import Node, qos_profile_latched

TRAJECTORY_TYPE = "trajectory_msgs/JointTrajectory"
ARRAY_TYPE = "std_msgs/Float64MultiArray"

_DEPTH = 10
_LIST = "controller_manager_msgs/srv/ListControllers"
# A trajectory's point lies this many periods ahead, so that the controller moves on when the next
# message is late.
_PERIODS_AHEAD = 2.0

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True, slots=True)
class Target:
    """Topic of a controller that takes joint commands.

    Attributes:
        topic: Full name of the topic.
        type: `TRAJECTORY_TYPE` or `ARRAY_TYPE`.
        joints: Joints that a message commands, in its order.
        quantity: ``position`` or ``velocity``, for arrays.
    """

    topic: str
    type: str
    joints: tuple[str, ...]
    quantity: str = "position"


def choose_targets(
    controllers: Iterable[Any], joints: Sequence[str], namespace: str
) -> list[Target]:
    """Return the topics of the active controllers that together command joints.

    Args:
        controllers: ``controller_manager_msgs/msg/ControllerState`` of all controllers.
        joints: Joints to command.
        namespace: Namespace of the controllers, such as ``/``.

    Returns:
        The topics; empty if a joint has no active controller that takes positions or velocities.
    """
    found: dict[str, Target] = {}
    for controller in controllers:
        if controller.state != "active":
            continue
        claimed = [name.rpartition("/") for name in controller.claimed_interfaces]
        own = list(dict.fromkeys(joint for joint, _, _ in claimed if joint))
        if not set(own) & set(joints):
            continue
        quantities = {quantity for _, _, quantity in claimed}
        base = f"{namespace.rstrip('/')}/{controller.name}"
        if controller.type.endswith("JointTrajectoryController"):
            target = Target(f"{base}/joint_trajectory", TRAJECTORY_TYPE, tuple(own))
        elif len(quantities) == 1 and quantities <= {"position", "velocity"}:
            (quantity,) = quantities
            target = Target(f"{base}/commands", ARRAY_TYPE, tuple(own), quantity)
        else:
            continue
        for joint in own:
            found.setdefault(joint, target)
    if any(joint not in found for joint in joints):
        return []
    return list(dict.fromkeys(found[joint] for joint in joints))


class CommandPublisher:
    """Publisher of joint commands to one controller.

    Args:
        node: Node of the publisher.
        target: The controller's topic.
        period_s: Period of the commands, s.
    """

    def __init__(self, node: Node, target: Target, period_s: float) -> None:
        self._node, self.target = node, target
        if target.type == TRAJECTORY_TYPE:
            self._message: Any = get_message("trajectory_msgs/msg/JointTrajectory")(
                joint_names=list(target.joints)
            )
            self._point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")()
            set_stamp(self._point.time_from_start, from_seconds(_PERIODS_AHEAD * period_s))
            self._message.points = [self._point]
        else:
            self._message = get_message("std_msgs/msg/Float64MultiArray")()
        self._publisher = node.create_publisher(type(self._message), target.topic, _DEPTH)

    def publish(
        self,
        positions: Mapping[str, float],
        velocities: Mapping[str, float],
        measured: Mapping[str, float],
    ) -> None:
        """Publish a command.

        Args:
            positions: Commanded positions by joint, rad or m.
            velocities: Commanded velocities by joint, rad/s or m/s.
            measured: Measured positions of all joints: those of the controller that are not
                commanded stay where they are.
        """
        names = self.target.joints
        if self.target.type == ARRAY_TYPE and self.target.quantity == "velocity":
            self._message.data = [velocities.get(name, 0.0) for name in names]
        else:
            values = [positions.get(name, measured.get(name, 0.0)) for name in names]
            if self.target.type == ARRAY_TYPE:
                self._message.data = values
            else:
                self._point.positions = values
        self._publisher.publish(self._message)

    def has_subscribers(self) -> bool:
        """Whether a controller receives the commands."""
        return int(self._publisher.get_subscription_count()) > 0

    def destroy(self) -> None:
        """Destroy the publisher."""
        self._node.destroy_publisher(self._publisher)


class ControllerWatch:
    """Calls a function with the controllers of ``controller_manager`` after each of their changes.

    Args:
        node: Node of the endpoints; the manager is in its namespace.
        on_controllers: Called with the ControllerState messages and the manager's namespace.
    """

    def __init__(self, node: Node, on_controllers: Callable[[list[Any], str], object]) -> None:
        self._on_controllers = on_controllers
        self._namespace = node.get_namespace()
        manager = f"{self._namespace.rstrip('/')}/controller_manager"
        self._client = node.create_client(get_service(_LIST), f"{manager}/list_controllers")
        self._is_asking = False
        # Published by managers since Jazzy; before, `query` asks when servo begins to move.
        node.create_subscription(
            get_message("controller_manager_msgs/msg/ControllerManagerActivity"),
            f"{manager}/activity",
            lambda _: self.query(),
            qos_profile_latched,
        )

    def query(self) -> None:
        """Request the controllers, unless a request is pending or the service is missing."""
        if self._is_asking or not self._client.service_is_ready():
            return
        self._is_asking = True
        future = self._client.call_async(get_service(_LIST).Request())
        future.add_done_callback(self._answered)

    # Any: the future of a response.
    def _answered(self, future: Any) -> None:
        self._is_asking = False
        if (response := future.result()) is not None:
            self._on_controllers(list(response.controller), self._namespace)

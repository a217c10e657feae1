"""Whom the joint sliders move: active controllers, a ``joint_state_publisher``, or nobody else."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from teleopctl.interfaces import from_seconds, get_message, get_service, set_stamp
from teleopctl.node import qos_profile_latched
from teleopctl.robot import Joints, JointSet

if TYPE_CHECKING:
    from teleopctl.node import Node

SLIDERS_TOPIC = "/joint_state_publisher_gui/joint_states"
"""Where sliders say what a ``joint_state_publisher`` shall publish (its ``source_list``)."""

_STATES_TOPIC = "/joint_states"
_LIST = "list_controllers"
# What joint_state_publisher_gui publishes at.
_RATE_HZ = 10.0
# The least that a movement takes; a slider that is dragged sends the next one meanwhile.
_SHORTEST_S = 0.2
_SPEED_WITHOUT_LIMIT = 1.0

# Any stands for messages: their classes are made at run time, from definitions.


class JointTarget(Protocol):
    """Somebody who moves joints.

    Attributes:
        description: Who that is, for the user, as Markdown.
        is_immediate: Whether the joints are at once where they are put.
    """

    description: str
    is_immediate: bool

    def moves(self, joint: str) -> bool:
        """Whether a joint can be moved."""

    def command(
        self, joints: JointSet, moved: Mapping[str, float], measured: Mapping[str, float]
    ) -> None:
        """Move joints.

        Args:
            joints: Where every joint shall be.
            moved: Those that the user has moved; radians or metres.
            measured: Where joints are.
        """

    def close(self) -> None:
        """End what it has opened."""


class _Nobody:
    """The joints are published by somebody who takes no orders."""

    is_immediate = False

    def __init__(self, description: str) -> None:
        self.description = description

    def moves(self, joint: str) -> bool:  # noqa: ARG002 -- none
        return False

    def command(self, *_: Any) -> None:
        return

    def close(self) -> None:
        return


class _Publisher:
    """The sliders are the ``joint_state_publisher_gui``: they, or one who listens, publish."""

    is_immediate = True

    def __init__(self, node: Node, topic: str, description: str, joints: JointSet) -> None:
        self.description = description
        self._node = node
        self._joints = joints
        self._type = get_message("sensor_msgs/msg/JointState")
        self._publisher = node.create_publisher(self._type, topic, 10)
        # A publisher of states goes on publishing; what listens to sliders does so itself.
        self._timer = (
            node.create_timer(1.0 / _RATE_HZ, self._publish) if topic == _STATES_TOPIC else None
        )

    def moves(self, joint: str) -> bool:
        return joint in self._joints.free

    def command(
        self,
        joints: JointSet,
        moved: Mapping[str, float],  # noqa: ARG002 -- all of them are published
        measured: Mapping[str, float],  # noqa: ARG002
    ) -> None:
        self._joints = joints
        self._publish()

    def _publish(self) -> None:
        state = self._type(name=self._joints.names, position=self._joints.positions())
        state.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(state)

    def close(self) -> None:
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        self._node.destroy_publisher(self._publisher)


@dataclass(frozen=True, slots=True)
class _Route:
    """A controller that takes positions.

    Attributes:
        name: Its node.
        joints: The joints that it commands, in its order.
        takes_trajectories: Whether it takes those, rather than bare positions.
    """

    name: str
    joints: tuple[str, ...]
    takes_trajectories: bool


class _Controllers:
    """Active controllers, each for its joints."""

    is_immediate = False

    def __init__(self, node: Node, routes: list[_Route], limits: Joints) -> None:
        names = ", ".join(f"`{route.name}`" for route in routes)
        self.description = f"The sliders move the robot through {names}."
        self._node = node
        self._limits = limits
        self._routes = routes
        self._trajectory = get_message("trajectory_msgs/msg/JointTrajectory")
        self._point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
        self._numbers = get_message("std_msgs/msg/Float64MultiArray")
        self._publishers = {
            route.name: node.create_publisher(self._trajectory, f"{route.name}/joint_trajectory", 1)
            if route.takes_trajectories
            else node.create_publisher(self._numbers, f"{route.name}/commands", 1)
            for route in routes
        }

    def moves(self, joint: str) -> bool:
        return any(joint in route.joints for route in self._routes)

    def command(
        self, joints: JointSet, moved: Mapping[str, float], measured: Mapping[str, float]
    ) -> None:
        wanted = dict(zip(joints.names, joints.positions(), strict=True))
        for route in self._routes:
            if not any(name in moved for name in route.joints):
                continue
            positions = [wanted.get(name, measured.get(name, 0.0)) for name in route.joints]
            if not route.takes_trajectories:
                self._publishers[route.name].publish(self._numbers(data=positions))
                continue
            point = self._point(positions=positions)
            seconds = max(
                self._duration(name, position - measured.get(name, position))
                for name, position in zip(route.joints, positions, strict=True)
            )
            set_stamp(point.time_from_start, from_seconds(seconds))
            self._publishers[route.name].publish(
                self._trajectory(joint_names=list(route.joints), points=[point])
            )

    def _duration(self, joint: str, distance: float) -> float:
        model = self._limits.get(joint)
        speed = model.limits.velocity if model is not None else 0.0
        if not 0.0 < speed < float("inf"):
            speed = _SPEED_WITHOUT_LIMIT
        return max(abs(distance) / speed, _SHORTEST_S)

    def close(self) -> None:
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)


class JointTargets:
    """Finds out, and follows when it changes, whom the sliders move.

    Args:
        node: Who asks and publishes.
        changed: Called with the new target.
    """

    def __init__(self, node: Node, changed: Callable[[JointTarget], object]) -> None:
        self._node = node
        self._changed = changed
        self._joints: JointSet | None = None
        self._limits: Joints | None = None
        self._target: JointTarget | None = None
        self._found: tuple[object, ...] = ()
        self._manager = ""
        self._routes: list[_Route] = []
        self._activity: Any = None
        self._client: Any = None

    @property
    def target(self) -> JointTarget | None:
        """Whom the sliders move now."""
        return self._target

    def begin(self, joints: JointSet, limits: Joints) -> None:
        """Look for those who move these joints."""
        self._joints, self._limits = joints, limits
        self._found = ()
        self.look()

    def look(self) -> None:
        """Look again; to be called when the graph has changed."""
        graph = self._node.graph()
        managers = sorted(
            token.name.removesuffix(f"/{_LIST}")
            for token in graph.endpoints
            if token.kind.name == "SS" and token.name.endswith(f"/{_LIST}")
        )
        manager = managers[0] if managers else ""
        if manager != self._manager:
            self._follow(manager)
        self._choose()

    def close(self) -> None:
        """End everything."""
        self._follow("")
        if self._target is not None:
            self._target.close()
            self._target = None

    def _follow(self, manager: str) -> None:
        """Listen to a controller manager, which says when its controllers change."""
        if self._activity is not None:
            self._node.destroy_subscription(self._activity)
            self._node.destroy_client(self._client)
            self._activity = self._client = None
        self._manager, self._routes = manager, []
        if manager:
            self._client = self._node.create_client(
                get_service("controller_manager_msgs/srv/ListControllers"), f"{manager}/{_LIST}"
            )
            self._activity = self._node.create_subscription(
                get_message("controller_manager_msgs/msg/ControllerManagerActivity"),
                f"{manager}/activity",
                lambda _message: self._ask(),
                qos_profile_latched,
            )

    def _ask(self) -> None:
        client = self._client
        future = client.call_async(client.srv_type.Request())
        future.add_done_callback(self._take_list)

    def _take_list(self, future: Any) -> None:
        response = future.result()
        if response is None:
            return
        namespace = self._manager.rpartition("/")[0]
        routes = []
        for controller in response.controller:
            joints = tuple(
                interface.removesuffix("/position")
                for interface in controller.required_command_interfaces
                if interface.endswith("/position")
            )
            takes_trajectories = controller.type.endswith("JointTrajectoryController")
            takes_numbers = controller.type.endswith(
                ("/ForwardCommandController", "/JointGroupPositionController")
            )
            if controller.state == "active" and joints and (takes_trajectories or takes_numbers):
                routes.append(_Route(f"{namespace}/{controller.name}", joints, takes_trajectories))
        self._routes = routes
        self._choose()

    def _choose(self) -> None:
        if self._joints is None or self._limits is None:
            return
        graph = self._node.graph()
        own = self._node.get_fully_qualified_name()
        others = sorted({token.full_name for token in graph.publishers(_STATES_TOPIC)} - {own})
        listeners = bool(graph.subscriptions(SLIDERS_TOPIC))
        found = (tuple(self._routes), self._manager, tuple(others), listeners)
        if found == self._found and self._target is not None:
            return
        self._found = found
        if self._target is not None:
            self._target.close()
        self._target = self._make(others, listeners=listeners)
        self._changed(self._target)

    def _make(self, others: list[str], *, listeners: bool) -> JointTarget:
        assert self._joints is not None
        assert self._limits is not None
        if self._routes:
            return _Controllers(self._node, self._routes, self._limits)
        if self._manager:
            return _Nobody(
                f"No active controller of `{self._manager}` takes positions: "
                "activate one in the tab **Controllers**."
            )
        if listeners:
            return _Publisher(
                self._node, SLIDERS_TOPIC, "The sliders put the joints.", self._joints
            )
        if not others:
            return _Publisher(
                self._node,
                _STATES_TOPIC,
                "The sliders put the joints: nobody else publishes `/joint_states`.",
                self._joints,
            )
        names = ", ".join(f"`{name}`" for name in others)
        return _Nobody(f"`/joint_states` comes from {names}, which takes no orders from here.")

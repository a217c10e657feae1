"""Receivers of the joint sliders' positions: controllers, published joint states, or none."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from teleopctl.interfaces import from_seconds, get_message, set_stamp
from teleopctl.node import Clock, ClockType
from teleopctl.robot import Joints, JointSet
from teleopctl.viewer.html import escaped_html
from teleopctl.viewer.panels.controller_managers import ControllerManagerWatch, controller_managers

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.viewer.panels.base import Page

# Rate of joint_state_publisher_gui.
_STATES_RATE_HZ = 10.0
# Rate of the steps to a position for controllers that apply positions at once.
_RAMP_RATE_HZ = 50.0
# Sliders move a robot at half of a joint's velocity limit, and at most at these speeds.
_SHARE_OF_LIMIT = 0.5
_FASTEST = {"prismatic": 0.25}
_FASTEST_TURN = 1.0
# Shortest duration of a motion; a dragged slider replaces the motion before its end.
_SHORTEST_S = 0.2

# Any: messages, whose classes are created from definitions at run time.


class JointMover(Protocol):
    """Interface for what the joint sliders move: controllers, or published joint states.

    Attributes:
        description: Sentence for the user about what the sliders move, as HTML.
        is_immediate: Whether commanded positions are reached at once, without measurement.
    """

    description: str
    is_immediate: bool

    def can_move(self, joint: str, measured: Mapping[str, float]) -> bool:
        """Return whether the sliders can move a joint, given the measured positions by joint.

        Args:
            joint: Name of the joint.
            measured: Measured positions by joint.
        """

    def command(
        self, joints: JointSet, moved_joints: Mapping[str, float], measured: Mapping[str, float]
    ) -> float:
        """Command the positions of moved joints; return the duration of the motion in seconds.

        Args:
            joints: Desired positions of all joints.
            moved_joints: Positions of the joints that the user has moved, in radians or metres.
            measured: Measured positions by joint.

        Returns:
            Duration of the motion, in seconds of the robot's time.
        """

    def close(self) -> None:
        """Destroy the mover's publishers and timers."""


class NoJointMover:
    """Joint mover that moves nothing, for a robot whose nodes take no position commands.

    Args:
        description: Sentence for the user, as HTML.
    """

    is_immediate = False

    def __init__(self, description: str) -> None:
        self.description = description

    def can_move(self, joint: str, measured: Mapping[str, float]) -> bool:  # noqa: ARG002 -- none
        """Return False: no joint can be moved."""
        return False

    def command(self, *_: Any) -> float:
        """Do nothing; return 0, the duration of the motion."""
        return 0.0

    def close(self) -> None:
        """Do nothing: there are no publishers."""


class StatePublisher:
    """Joint mover that publishes the sliders' positions as JointState messages.

    Args:
        node: The viewer's node.
        topic: Topic of the joint states.
        description: Sentence for the user, as HTML.
        joints: Initial positions.
        repeats: Whether to publish at 10 Hz, or only when a slider is moved.
    """

    is_immediate = True

    def __init__(
        self, node: Node, topic: str, description: str, joints: JointSet, *, repeats: bool
    ) -> None:
        self.description = description
        self._node = node
        self._joints = joints
        self._type = get_message("sensor_msgs/msg/JointState")
        self._publisher = node.create_publisher(self._type, topic, 10)
        self._timer = node.create_timer(1.0 / _STATES_RATE_HZ, self._publish) if repeats else None

    def can_move(self, joint: str, measured: Mapping[str, float]) -> bool:  # noqa: ARG002 -- always
        """Return whether a joint is independent; mimic joints cannot be moved."""
        return joint in self._joints.free

    def command(
        self,
        joints: JointSet,
        moved_joints: Mapping[str, float],  # noqa: ARG002 -- all of them are published
        measured: Mapping[str, float],  # noqa: ARG002
    ) -> float:
        """Publish the positions of all joints as a JointState; return 0, the duration."""
        self._joints = joints
        self._publish()
        return 0.0

    def _publish(self) -> None:
        state = self._type(name=self._joints.names, position=self._joints.positions())
        state.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(state)

    def close(self) -> None:
        """Destroy the publisher and its timer."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        self._node.destroy_publisher(self._publisher)


@dataclass(frozen=True, slots=True)
class PositionController:
    """Active controller that takes joint positions or trajectories.

    Attributes:
        name: Full name of the controller's node.
        joints: Joints that the controller commands, in the controller's order.
        takes_trajectories: Whether the controller takes trajectories, not arrays of positions.
    """

    name: str
    joints: tuple[str, ...]
    takes_trajectories: bool


class ControllerMover:
    """Joint mover that sends the sliders' positions to active controllers.

    Args:
        node: The viewer's node.
        routes: Controllers that take positions.
        limits: Limits of the joints.
    """

    is_immediate = False

    def __init__(self, node: Node, routes: list[PositionController], limits: Joints) -> None:
        names = ", ".join(
            f"<b>{escaped_html(route.name.rpartition('/')[2])}</b>"
            + (f" ({escaped_html(', '.join(route.joints))})" if len(routes) > 1 else "")
            for route in routes
        )
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
        # Motions by controller: present positions and target positions.
        self._ramps: dict[str, tuple[list[float], list[float]]] = {}
        self._timer = node.create_timer(
            1.0 / _RAMP_RATE_HZ, self._ramp, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self._timer.cancel()

    def can_move(self, joint: str, measured: Mapping[str, float]) -> bool:
        """Return whether a controller commands the joint and all its joints are measured."""
        return any(
            joint in route.joints and all(name in measured for name in route.joints)
            for route in self._routes
        )

    def command(
        self, joints: JointSet, moved_joints: Mapping[str, float], measured: Mapping[str, float]
    ) -> float:
        """Start motions of the moved joints' controllers; return the longest duration (s)."""
        wanted = dict(zip(joints.names, joints.positions(), strict=True))
        longest = 0.0
        for route in self._routes:
            concerned = any(name in moved_joints for name in route.joints)
            if not concerned or not all(name in measured for name in route.joints):
                continue
            positions = [wanted.get(name, measured[name]) for name in route.joints]
            seconds = max(
                abs(position - measured[name]) / self._speed(name)
                for name, position in zip(route.joints, positions, strict=True)
            )
            seconds = max(seconds, _SHORTEST_S)
            longest = max(longest, seconds)
            if route.takes_trajectories:
                point = self._point(positions=positions)
                set_stamp(point.time_from_start, from_seconds(seconds))
                self._publishers[route.name].publish(
                    self._trajectory(joint_names=list(route.joints), points=[point])
                )
            else:
                start, _ = self._ramps.get(route.name) or (
                    [measured[name] for name in route.joints],
                    [],
                )
                self._ramps[route.name] = (start, positions)
                self._timer.reset()
        return longest

    def _speed(self, joint: str) -> float:
        model = self._limits.get(joint)
        if model is None:
            return _FASTEST_TURN
        fastest = _FASTEST.get(model.joint.type, _FASTEST_TURN)
        limit = model.limits.velocity
        return min(fastest, _SHARE_OF_LIMIT * limit) if 0.0 < limit < math.inf else fastest

    def _ramp(self) -> None:
        """Send the next step to the controllers that take arrays of positions."""
        for route in self._routes:
            if route.name not in self._ramps:
                continue
            now, wanted = self._ramps[route.name]
            steps = [self._speed(name) / _RAMP_RATE_HZ for name in route.joints]
            now = [
                goal if abs(goal - at) <= step else at + math.copysign(step, goal - at)
                for at, goal, step in zip(now, wanted, steps, strict=True)
            ]
            self._publishers[route.name].publish(self._numbers(data=now))
            if now == wanted:
                del self._ramps[route.name]
            else:
                self._ramps[route.name] = (now, wanted)
        if not self._ramps:
            self._timer.cancel()

    def close(self) -> None:
        """Destroy the publishers to the controllers, and the timer."""
        self._node.destroy_timer(self._timer)
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)


SLIDERS_TOPIC = "/joint_state_publisher_gui/joint_states"
"""Topic of the sliders' positions for a ``joint_state_publisher`` (its ``source_list``)."""

STATES_TOPIC = "/joint_states"


class MoverSelector:
    """Selection of what the joint sliders move, by the nodes in the ROS graph.

    The first of these that applies:

    - active controllers that take positions;
    - nothing, if a controller manager has no such controller;
    - a ``joint_state_publisher`` that subscribes to `SLIDERS_TOPIC`;
    - nothing, if other nodes publish ``/joint_states``, or have published it and ended: after a
      crash of the driver, the drawn robot must not move by hand, except after `take_over`;
    - joint states that the sliders publish on ``/joint_states``.

    Args:
        page: The viewer's node.
        changed: Function called with the new mover.

    Attributes:
        is_measured: Whether other nodes publish ``/joint_states``.
    """

    def __init__(self, page: Page, changed: Callable[[JointMover], object]) -> None:
        self._page = page
        self._node = page.node
        self._changed = changed
        self._joints: JointSet | None = None
        self._limits: Joints | None = None
        self._mover: JointMover | None = None
        self._found: tuple[object, ...] = ()
        self._watches: dict[str, ControllerManagerWatch] = {}
        self._gone: tuple[str, ...] = ()
        self.is_measured = False
        self._is_started = False

    @property
    def mover(self) -> JointMover | None:
        """The present joint mover; None before `set_joints` and `start`, and after `close`."""
        return self._mover

    @property
    def can_take_over(self) -> bool:
        """Whether `take_over` is possible: all publishers of joint states have gone."""
        return isinstance(self._mover, NoJointMover) and bool(self._gone) and not self._others()

    def set_joints(self, joints: JointSet, limits: Joints) -> None:
        """Set the robot's joints and limits, and select the joint mover unless stopped."""
        self._joints, self._limits = joints, limits
        self._found = ()
        self.update()

    def start(self) -> None:
        """Subscribe to the controller managers, and select the joint mover."""
        self._is_started = True
        self.update()

    def stop(self) -> None:
        """Unsubscribe from the controller managers; the joint mover stays."""
        self._is_started = False
        for watch in self._watches.values():
            watch.close()
        self._watches.clear()

    def update(self) -> None:
        """Select the joint mover again after the ROS graph changed; do nothing while stopped."""
        if not self._is_started:
            return
        managers = controller_managers(self._node)
        for name in [name for name in self._watches if name not in managers]:
            self._watches.pop(name).close()
        for name in managers:
            if name not in self._watches:
                self._watches[name] = ControllerManagerWatch(
                    self._page, name, self._choose, lambda _reason: None
                )
        self._choose()

    def take_over(self) -> None:
        """Let the sliders publish the joint states, in place of the publishers that have gone."""
        self._gone = ()
        self._choose()

    def close(self) -> None:
        """Unsubscribe from the controller managers, and close the joint mover."""
        self.stop()
        if self._mover is not None:
            self._mover.close()
            self._mover = None

    def _others(self) -> tuple[str, ...]:
        own = self._node.get_fully_qualified_name()
        publishers = self._node.graph().publishers(self._node.resolve_topic_name(STATES_TOPIC))
        return tuple(sorted({token.full_name for token in publishers} - {own}))

    def _choose(self) -> None:
        if self._joints is None or self._limits is None:
            return
        others = self._others()
        self.is_measured = bool(others)
        self._gone = others or self._gone
        routes = [route for watch in self._watches.values() for route in self._routes_of(watch)]
        listens = bool(self._node.count_subscribers(SLIDERS_TOPIC))
        # The facts that decide in each case: other changes must not interrupt moving joints.
        managers = tuple(self._watches)
        found: tuple[object, ...]
        if routes:
            found = ("controllers", *routes)
        elif managers:
            found = ("managers", *managers)
        elif listens:
            found = ("listener",)
        else:
            found = ("publishers", others, self._gone)
        if found == self._found and self._mover is not None:
            return
        self._found = found
        if self._mover is not None:
            self._mover.close()
        self._mover = self._make(routes, others, listens=listens)
        self._changed(self._mover)

    def _routes_of(self, watch: ControllerManagerWatch) -> list[PositionController]:
        namespace = watch.name.rpartition("/")[0]
        routes = (_position_controller(f"{namespace}/{one.name}", one) for one in watch.controllers)
        return [
            route
            for route in routes
            if route is not None and any(name in (self._limits or ()) for name in route.joints)
        ]

    def _make(
        self, routes: list[PositionController], others: tuple[str, ...], *, listens: bool
    ) -> JointMover:
        assert self._joints is not None
        assert self._limits is not None
        if routes:
            return ControllerMover(self._node, routes, self._limits)
        if self._watches:
            return NoJointMover(
                f"No active controller of {_names(self._watches)} takes positions: "
                "activate one in the panel <b>Controllers</b>."
            )
        if listens:
            return StatePublisher(
                self._node, SLIDERS_TOPIC, "The sliders set the joints' positions.", self._joints,
                repeats=False,
            )  # fmt: skip
        if others:
            return NoJointMover(
                f"{STATES_TOPIC} is published by {_names(others)}, which takes no commands."
            )
        if self._gone:
            return NoJointMover(
                f"{_names(self._gone)}, which published {STATES_TOPIC}, has disappeared."
            )
        return StatePublisher(
            self._node,
            STATES_TOPIC,
            f"The sliders set the joints: no other node publishes {STATES_TOPIC}.",
            self._joints,
            repeats=True,
        )


def _position_controller(name: str, controller: Any) -> PositionController | None:
    """Return a controller as `PositionController`, or None if inactive or of another type.

    Command interfaces are named JOINT/INTERFACE, or CONTROLLER/JOINT/INTERFACE for interfaces of a
    chained controller.
    """
    interfaces = list(controller.required_command_interfaces)
    takes_trajectories = controller.type.endswith("/JointTrajectoryController")
    takes_positions = controller.type.endswith(
        ("/ForwardCommandController", "/JointGroupPositionController")
    ) and all(interface.endswith("/position") for interface in interfaces)
    if controller.state != "active" or not (takes_trajectories or takes_positions):
        return None
    chained = [one for one in controller.chain_connections if one.reference_interfaces]
    joints = []
    for interface in interfaces:
        joint = interface.rpartition("/")[0]
        for connection in chained:
            joint = joint.removeprefix(f"{connection.name}/")
        joints.append(joint)
    return (
        PositionController(name, tuple(dict.fromkeys(joints)), takes_trajectories)
        if joints
        else None
    )


def _names(names: Any) -> str:
    return ", ".join(f"<b>{escaped_html(name)}</b>" for name in names)

"""Who moves joints for the sliders: active controllers, publishers of joint states, or nobody."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from teleopctl.interfaces import from_seconds, get_message, set_stamp
from teleopctl.node import Clock, ClockType
from teleopctl.robot import Joints, JointSet
from teleopctl.viewer.html import escaped

if TYPE_CHECKING:
    from teleopctl.node import Node

# What joint_state_publisher_gui publishes at.
_STATES_RATE_HZ = 10.0
# A position that a controller takes at once is reached in steps of this rate.
_RAMP_RATE_HZ = 50.0
# Sliders move a robot gently: at half of what a joint may do, and at most so fast.
_SHARE_OF_LIMIT = 0.5
_FASTEST = {"prismatic": 0.25}
_FASTEST_TURN = 1.0
# The least that a movement takes; a slider that is dragged sends the next one meanwhile.
_SHORTEST_S = 0.2

# Any stands for messages: their classes are made at run time, from definitions.


class JointMover(Protocol):
    """Interface of what the joint sliders move: controllers, or published joint states.

    Attributes:
        description: Who that is, for the user, as HTML.
        is_immediate: Whether joints are at once where they are put, so that nothing need be
            measured.
    """

    description: str
    is_immediate: bool

    def moves(self, joint: str, measured: Mapping[str, float]) -> bool:
        """Return whether a joint can be moved."""

    def command(
        self, joints: JointSet, moved: Mapping[str, float], measured: Mapping[str, float]
    ) -> float:
        """Command joint positions.

        Args:
            joints: Where every joint shall be.
            moved: Those that the user has moved; radians or metres.
            measured: Where joints are.

        Returns:
            How long that takes, in seconds of the robot's time.
        """

    def close(self) -> None:
        """Close publishers and clients."""


class NoMover:
    """No mover: the joint states come from a node that takes no commands.

    Args:
        description: Who that is, as HTML.
    """

    is_immediate = False

    def __init__(self, description: str) -> None:
        self.description = description

    def moves(self, joint: str, measured: Mapping[str, float]) -> bool:  # noqa: ARG002 -- none
        """Return False."""
        return False

    def command(self, *_: Any) -> float:
        """Do nothing."""
        return 0.0

    def close(self) -> None:
        """Do nothing: there is nothing to end."""


class StatePublisher:
    """Mover that publishes the sliders' positions as joint states.

    Args:
        node: Who publishes.
        topic: Where.
        description: What that is, as HTML.
        joints: Where the joints are at first.
        repeats: Whether to go on publishing, for those who come late; who listens does so itself.
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

    def moves(self, joint: str, measured: Mapping[str, float]) -> bool:  # noqa: ARG002 -- always
        """Return whether a joint can be moved: each that follows no other joint."""
        return joint in self._joints.free

    def command(
        self,
        joints: JointSet,
        moved: Mapping[str, float],  # noqa: ARG002 -- all of them are published
        measured: Mapping[str, float],  # noqa: ARG002
    ) -> float:
        """Publish the joint positions."""
        self._joints = joints
        self._publish()
        return 0.0

    def _publish(self) -> None:
        state = self._type(name=self._joints.names, position=self._joints.positions())
        state.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(state)

    def close(self) -> None:
        """Stop publishing."""
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
        self._node.destroy_publisher(self._publisher)


@dataclass(frozen=True, slots=True)
class Route:
    """A controller that takes joint positions.

    Attributes:
        name: Its node.
        joints: The joints that it commands, in its order.
        takes_trajectories: Whether it takes those, rather than bare positions.
    """

    name: str
    joints: tuple[str, ...]
    takes_trajectories: bool


class ControllerMover:
    """Mover that sends joint positions to active controllers.

    Args:
        node: Who publishes to them.
        routes: The controllers.
        limits: What joints may do.
    """

    is_immediate = False

    def __init__(self, node: Node, routes: list[Route], limits: Joints) -> None:
        names = ", ".join(f"<b>{escaped(route.name.rpartition('/')[2])}</b>" for route in routes)
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
        # Positions on their way, by route: where they are, and where they go.
        self._ramps: dict[str, tuple[list[float], list[float]]] = {}
        self._timer = node.create_timer(
            1.0 / _RAMP_RATE_HZ, self._ramp, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self._timer.cancel()

    def moves(self, joint: str, measured: Mapping[str, float]) -> bool:
        """Return whether a controller commands a joint and all of its joints are measured."""
        return any(
            joint in route.joints and all(name in measured for name in route.joints)
            for route in self._routes
        )

    def command(
        self, joints: JointSet, moved: Mapping[str, float], measured: Mapping[str, float]
    ) -> float:
        """Send each controller the positions of its joints."""
        wanted = dict(zip(joints.names, joints.positions(), strict=True))
        longest = 0.0
        for route in self._routes:
            concerned = any(name in moved for name in route.joints)
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
        """Take the positions that controllers take at once a step further."""
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
        """Stop sending."""
        self._node.destroy_timer(self._timer)
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)

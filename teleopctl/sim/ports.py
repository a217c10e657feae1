"""Outputs of the lockstep loop as ROS topics and log lines."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from teleopctl.interfaces import PreparedMessage, get_message, set_stamp, to_seconds
from teleopctl.mujoco_model import FixedBase, RobotModel, quaternion
from teleopctl.robot import RESET_FRAME
from teleopctl.sim.sensors.interfaces import SensorInterfaces
from teleopctl.sim.simulation import Simulation
from teleopctl.tf import StaticTransformBroadcaster, TransformBroadcaster

if TYPE_CHECKING:
    from teleopctl.node import Node, Publisher

_Clock = get_message("rosgraph_msgs/msg/Clock")
_JointState = get_message("sensor_msgs/msg/JointState")
_FreeJointState = get_message("mujoco_ros2_control_msgs/msg/FreeJointState")
_FreeJointStateArray = get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray")
_TransformStamped = get_message("geometry_msgs/msg/TransformStamped")

VIEW_TOPIC = "/mujoco_sim/joint_states"
FREE_BODIES_TOPIC = "/mujoco_sim/free_joint_states"
CHANGES_TOPIC = "/mujoco_sim/changes"
"""Topic of changes by services, each with the simulated time at which it acted."""


# Any: a message, whose class is made at run time.
def _standing(base: FixedBase) -> Any:
    """Return the static transform from the world to a fixed root link, as a message."""
    assert base.pose is not None
    transform = _TransformStamped(child_frame_id=base.link)
    transform.header.frame_id = base.world_frame
    place, turn = transform.transform.translation, transform.transform.rotation
    place.x, place.y, place.z = base.pose.xyz
    turn.w, turn.x, turn.y, turn.z = map(float, quaternion(base.pose))
    return transform


def reported_joints(model: RobotModel) -> npt.NDArray[np.intp]:
    """Return the indices of the joints whose states go to the controller, (n,)."""
    reported = [
        index
        for index, joint in enumerate(model.joints)
        if joint.state_interfaces or joint.mimic is not None
    ]
    return np.array(reported, dtype=np.intp)


class JointStateView(NamedTuple):
    """Joint states of a control tick, in memory that is written again at the next tick.

    Attributes:
        name: Names of the joints, then of the sensors' state interfaces.
        position: Positions (rad or m), then the sensors' values.
        velocity: Velocities (rad/s or m/s), then NaN.
        effort: Efforts (N m or N), then NaN.
    """

    name: list[str]
    position: memoryview[float]
    velocity: memoryview[float]
    effort: memoryview[float]


class HostedController(Protocol):
    """Controller in the simulator's process, which computes its commands when it is called."""

    @property
    def is_connected(self) -> bool:
        """Whether the controller reads states and answers them with commands."""

    @property
    def published_ns(self) -> int:
        """Time of the state whose commands were published on the topic last; -1 for none."""

    def simulation_started(self) -> None:
        """Note that the model is built: `update` will be called from now on."""

    def update(self, states: JointStateView, time_ns: int, reset: bool) -> None:
        """Compute the commands for the states of a control tick, on the simulation's thread.

        Args:
            states: Joint states.
            time_ns: Simulated time, in nanoseconds.
            reset: Whether the simulation was reset since the last call.
        """


class TopicPorts:
    """Outputs of the lockstep loop: topics for clock, joint states and free bodies, and log lines.

    Messages are created once; new values are written into their bytes each time.

    Args:
        node: Node of the publishers.
        simulation: Simulation to publish, as of its last `Simulation.read`.
        states_topic: Topic of the joint states for the controller.
        interfaces: State interfaces of sensors. Their values are published as positions under the
            full names of the interfaces, after those of the joints.
        controller: Controller in this process; None for controllers elsewhere.

    Attributes:
        publishes_states: Whether states are published on their topic: always without a hosted
            controller, else if the topic has subscribers.
    """

    def __init__(
        self,
        node: Node,
        simulation: Simulation,
        states_topic: str,
        interfaces: SensorInterfaces | None = None,
        controller: HostedController | None = None,
    ) -> None:
        self._controller = controller
        self.publishes_states = controller is None
        self._simulation = simulation
        self._interfaces = interfaces if interfaces is not None and interfaces.names else None
        self._logger = node.get_logger()
        reported = reported_joints(simulation.model)
        measured = self._interfaces.names if self._interfaces is not None else ()
        self._state = _JointStates(simulation, reported, measured)
        self._state_after_reset = _JointStates(simulation, reported, measured, RESET_FRAME)
        self._view = _JointStates(simulation, np.arange(len(simulation.joint_names)))
        self._resets = simulation.resets
        self._time = _Clock()
        self._clock_publisher = node.create_publisher(_Clock, "/clock", 10)
        self._state_publisher = node.create_publisher(_JointState, states_topic, 10)
        self._view_publisher = node.create_publisher(_JointState, VIEW_TOPIC, 10)
        self._node = node
        fixed = simulation.model.fixed
        if fixed is not None and fixed.pose is not None:
            # The fixed root link is not at the origin of the frame of all other poses.
            StaticTransformBroadcaster(node).sendTransform(_standing(fixed))
        self._bodies: FreeBodyPorts | None = None
        self.bodies_changed()

    def bodies_changed(self) -> None:
        """Update the published free bodies after some were spawned or deleted."""
        if self._bodies is not None:
            self._bodies.update_bodies()
        elif self._simulation.free_bodies.bodies:
            self._bodies = FreeBodyPorts(self._node, self._simulation)

    def show_base(self, shown: bool) -> None:
        """Set whether the robot's free root link is published on ``/tf``."""
        if self._bodies is not None:
            self._bodies.show_base(shown)

    def has_controller(self) -> bool:
        """Return whether the joint states of control ticks have a subscriber."""
        return self._state_publisher.get_subscription_count() > 0

    def has_clock(self) -> bool:
        """Return whether ``/clock`` has a subscriber."""
        return self._clock_publisher.get_subscription_count() > 0

    def is_viewed(self) -> bool:
        """Return whether the viewers' joint states or the free bodies' poses have a subscriber."""
        if self._view_publisher.get_subscription_count() > 0:
            return True
        return self._bodies is not None and self._bodies.is_viewed()

    def subscription_counts(self) -> dict[str, int]:
        """Return subscription counts by topic: clock, viewers' joint states and free bodies."""
        publishers = [self._clock_publisher, self._view_publisher]
        if self._bodies is not None:
            publishers += self._bodies.publishers()
        return {each.topic_name: each.get_subscription_count() for each in publishers}

    def publish_clock(self, time_ns: int) -> None:
        """Publish a simulated time on ``/clock``."""
        set_stamp(self._time.clock, time_ns)
        self._clock_publisher.publish(self._time)

    def publish_state(self, time_ns: int) -> None:
        """Publish the joint states of a control tick, which the controller answers."""
        simulation = self._simulation
        reset = simulation.resets != self._resets
        message = self._state_after_reset if reset else self._state
        self._resets = simulation.resets
        if self._interfaces is not None:
            message.measured = self._interfaces.read(*simulation.observe())
        data = message.at(time_ns)
        if self._controller is not None:
            self._controller.update(message.view, time_ns, reset)
        if self.publishes_states:
            self._state_publisher.publish(data)

    def publish_view(self, time_ns: int) -> None:
        """Publish joint states and free bodies' poses for viewers and cameras."""
        if self._bodies is not None:
            self._bodies.publish(time_ns)
        self._view_publisher.publish(self._view.at(time_ns))

    def controller_lost(self, time_ns: int, waited_s: float) -> None:
        """Log a warning that no command arrived for a state, and that the joints hold."""
        what = (
            f"No command for the state of {to_seconds(time_ns):.3f} s came within {waited_s:g} s"
            if waited_s > 0.0
            else f"The controller disappeared at {to_seconds(time_ns):.3f} s"
        )
        self._logger.warning(f"{what}; the joints hold, and the simulation continues without it")

    def controller_back(self, time_ns: int) -> None:
        """Log that the controller answers again."""
        self._logger.info(f"The controller answers again at {to_seconds(time_ns):.3f} s")

    def fell_behind(self, seconds: float, factor: float) -> None:
        """Log the wall time lost and the real-time factor reached, at most every 10 s."""
        self._logger.warning(
            f"The simulation is slower than its real_time_factor and lost {seconds:.2f} s; it "
            f"reached {factor:.2f} in the last second",
            throttle_duration_sec=10.0,
        )

    def diverged(self, time_ns: int) -> None:
        """Log that the robot's physics became unstable and was reset, at most every 10 s."""
        self._logger.error(
            f"Physics became unstable before {to_seconds(time_ns):.3f} s and was reset; check "
            "masses and inertias, or use a smaller timestep",
            throttle_duration_sec=10.0,
        )

    def commands_cut(self, sentences: Sequence[str]) -> None:
        """Log each sentence, on a joint's first command beyond its limits, as a warning."""
        for sentence in sentences:
            self._logger.warning(sentence)

    def objects_reset(self, time_ns: int, things: Sequence[str]) -> None:
        """Log which objects' physics became unstable and was reset, at most every 10 s."""
        names = ", ".join(f"'{thing}'" for thing in dict.fromkeys(things))
        self._logger.error(
            f"Physics of {names} became unstable before {to_seconds(time_ns):.3f} s: reset to "
            "the start pose; the rest continues; check its mass and inertia",
            throttle_duration_sec=10.0,
        )


class _JointStates:
    """JointState message whose numbers are written in place.

    Args:
        simulation: Simulation of the joints, as of its last `Simulation.read`.
        joints: Indices of the joints to publish, (n,).
        measured: Names of the sensors' state interfaces.
        frame: Frame in the header.

    Attributes:
        measured: Values of the sensors' state interfaces.
        view: Names and numbers of the message, which `at` writes.
    """

    def __init__(
        self,
        simulation: Simulation,
        joints: npt.NDArray[np.intp],
        measured: Sequence[str] = (),
        frame: str = "",
    ) -> None:
        self.measured: Sequence[float] = ()
        self._joints, count = joints, len(joints)
        names = [*(simulation.joint_names[joint] for joint in joints), *measured]
        # JointState requires as many velocities and efforts as names.
        unknown = np.full(len(names), np.nan)
        message = _JointState(name=names, position=unknown, velocity=unknown, effort=unknown)
        message.header.frame_id = frame
        self._message = PreparedMessage(message, ("position", "velocity", "effort"))
        position, velocity, effort = self._message.numbers.values()
        self.view = JointStateView(names, position, velocity, effort)
        self._measured = position[count:]
        sources = (simulation.positions, simulation.velocities, simulation.efforts)
        in_order = np.array_equal(joints, np.arange(len(simulation.joint_names)))
        self._taken = [] if in_order else [(source, np.zeros(count)) for source in sources]
        self._copied = [
            (numbers[:count], taken.data)
            for numbers, taken in zip(
                (position, velocity, effort),
                sources if in_order else [taken for _, taken in self._taken],
                strict=True,
            )
        ]

    def at(self, time_ns: int) -> bytearray:
        """Return the serialized JointState message of a time, valid until the next call."""
        self._message.set_stamp(time_ns)
        for source, taken in self._taken:
            source.take(self._joints, out=taken, mode="clip")
        # Memory views: numpy takes four times as long to copy a few numbers.
        for numbers, values in self._copied:
            numbers[:] = values
        if self.measured:
            self._measured[:] = memoryview(array("d", self.measured))
        return self._message.data


class FreeBodyPorts:
    """Publishers of the free bodies' poses and velocities, and of their transforms on ``/tf``.

    The robot's own root link is among the transforms only on request: mostly another node
    publishes its pose, such as odometry, and a frame has one parent.

    Args:
        node: Node of the publishers.
        simulation: Simulation of the free bodies.
    """

    def __init__(self, node: Node, simulation: Simulation) -> None:
        self._node = node
        self._simulation = simulation
        self._broadcaster: TransformBroadcaster | None = None
        self._publisher = node.create_publisher(_FreeJointStateArray, FREE_BODIES_TOPIC, 10)
        self._base_shown = False
        self.update_bodies()

    def update_bodies(self) -> None:
        """Set the published bodies to those that the simulation has now."""
        self._bodies = bodies = self._simulation.free_bodies
        self._states = _FreeJointStateArray(
            free_joints=[_FreeJointState(name=body.link) for body in bodies.bodies]
        )
        self._transforms = [_TransformStamped(child_frame_id=b.link) for b in bodies.bodies]
        self._states.header.frame_id = self._simulation.model.world_frame
        states = self._states.free_joints
        for state, transform, body in zip(states, self._transforms, bodies.bodies, strict=True):
            transform.header.frame_id = body.parent
            # A shared header, which `publish` stamps.
            state.pose.header = state.twist.header = transform.header
        self._has_base = self._simulation.model.base is not None
        self.show_base(self._base_shown)

    def show_base(self, shown: bool) -> None:
        """Set whether the robot's free root link is published on ``/tf``."""
        self._base_shown = shown
        # The root link is the first of the free bodies.
        self._shown = self._transforms[1 if self._has_base and not shown else 0 :]
        if self._shown and self._broadcaster is None:
            self._broadcaster = TransformBroadcaster(self._node)

    def is_viewed(self) -> bool:
        """Return whether any topic with body poses has a subscriber."""
        return any(publisher.get_subscription_count() > 0 for publisher in self.publishers())

    # Any: messages, whose classes are made at run time.
    def publishers(self) -> list[Publisher[Any]]:
        """Return the publisher of the free bodies' states, and that of ``/tf`` if in use."""
        if self._shown and self._broadcaster is not None:
            return [self._publisher, self._broadcaster.pub_tf]
        return [self._publisher]

    def publish(self, time_ns: int) -> None:
        """Publish the free bodies' poses and velocities, and the transforms shown on ``/tf``."""
        set_stamp(self._states.header.stamp, time_ns)
        for index, transform in enumerate(self._transforms):
            x, y, z, qw, qx, qy, qz = map(float, self._bodies.pose(index))
            set_stamp(transform.header.stamp, time_ns)
            state = self._states.free_joints[index]
            pose, move = state.pose.pose, transform.transform
            for point in (pose.position, move.translation):
                point.x, point.y, point.z = x, y, z
            for turn in (pose.orientation, move.rotation):
                turn.w, turn.x, turn.y, turn.z = qw, qx, qy, qz
            linear, angular = state.twist.twist.linear, state.twist.twist.angular
            twist = map(float, self._bodies.twist(index))
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = twist
        self._publisher.publish(self._states)
        if self._shown and self._broadcaster is not None:
            self._broadcaster.sendTransform(self._shown)

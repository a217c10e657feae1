"""Test commands for each kind of controller in a robot check, and the measured motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.control import POSITION, ChainableControllerInterface
from teleopctl.interfaces import get_message
from teleopctl.nodes.robot_check.base_motion import (
    ENOUGH,
    MOVING_S,
    SPEED,
    TURN,
    BaseMotion,
    base_pose,
)
from teleopctl.nodes.robot_check.collision_free import free_targets
from teleopctl.nodes.robot_check.stability import AT_LIMIT

if TYPE_CHECKING:
    from teleopctl.control import CommandInterface, ControllerSpec, ControlStack
    from teleopctl.mujoco_model import JointSpec
    from teleopctl.sim import SimulatedRobot, Simulation

# Commanded distance of a joint, in rad or m, and commanded speed, in rad/s or m/s.
_STEP = 0.2
_JOINT_SPEED = 0.5
# Largest commanded speed of a base as a fraction of its wheels' fastest speed.
_BELOW_LIMIT = 0.8
# Additional wait for the end of a trajectory or a gripper's motion, in s.
_ARRIVING_S = 1.0
# Commanded effort as a fraction of a joint's limit, and in N m or N for a joint without a limit.
_EFFORT_PART = 0.3
_EFFORT = 20.0
# Smallest motion by efforts that counts, in rad or m.
_SOME = 0.01

# Topics of velocity commands, which depend on the controller and on whether they are stamped.
_VELOCITIES = ("~/cmd_vel", "~/cmd_vel_unstamped", "~/reference", "~/reference_unstamped")
# Parameters of controllers with the radius of their wheels.
_RADII = (
    *("wheel_radius", "wheels_radius", "rear_wheels_radius", "front_wheels_radius"),
    *("traction_wheels_radius", "kinematics.wheels_radius"),
)
_IN_PLACE = ("DiffDriveController", "MecanumDriveController", "OmniWheelDriveController")

# Any stands for messages: their classes are created at run time, from definitions.

# Yields once per control period; returns whether something moved, and a summary as text.
_Act = Generator[None, None, tuple[bool, str]]


class ControllerTrial(NamedTuple):
    """Result of testing one controller: whether its joints or base moved, and how far.

    Attributes:
        controller: Name of the controller.
        type: Type of the controller: the name of its plug-in.
        moved: Whether joints or base moved as commanded.
        result: Measured motion, or the reason why nothing moved, as text.
    """

    controller: str
    type: str
    moved: bool
    result: str


class ControllerTester:
    """Tester that sends commands to controllers in simulation, and measures the motion.

    Args:
        stack: Control stack with the controllers.
        simulation: Simulation of the robot that the controllers move.
        robot: Simulated robot with the description and the model.
    """

    def __init__(self, stack: ControlStack, simulation: Simulation, robot: SimulatedRobot) -> None:
        self._stack = stack
        self._simulation = simulation
        self._description = robot.description
        self._base_link = None if robot.model.base is None else robot.model.base.body.link
        joints = robot.model.joints
        self._joints: Mapping[str, JointSpec] = {joint.name: joint for joint in joints}

    def wait(self, seconds: float) -> Iterator[None]:
        """Yield once per control period until ``seconds`` of simulated time have passed."""
        for _ in range(round(seconds * self._stack.manager.update_rate)):
            yield

    def try_controller(
        self, spec: ControllerSpec, motions: list[ControllerTrial]
    ) -> Iterator[None]:
        """Command a controller, yielding each period; append the result to ``motions`` if testable.

        Args:
            spec: Controller to command.
            motions: List to which the result is appended.
        """
        kind = spec.type.rpartition("/")[2]
        controller = spec.controller
        chainable = controller if isinstance(controller, ChainableControllerInterface) else None
        if chainable is not None and chainable.in_chained_mode:
            return  # tested with the controller that commands its references
        endpoints = self._stack.nodes[spec.name].endpoints
        if "~/joint_trajectory" in endpoints:
            act = self._trajectory(spec)
        elif kind.endswith("GripperActionController"):
            act = self._gripper(spec)
        elif chainable is not None and kind == "PidController":
            act = self._references(spec, chainable)
        elif topic := next((name for name in _VELOCITIES if name in endpoints), ""):
            act = self._base(spec, topic)
        elif chainable is not None and "~/joint_references" in endpoints:
            act = self._joint_references(spec, chainable)
        elif "~/commands" in endpoints and kind != "GpioCommandController":
            act = self._commands(spec, controller.command_interfaces, self._floats)
        else:
            return
        moved, summary = yield from act
        motions.append(ControllerTrial(spec.name, spec.type, moved, summary))

    # -- joints ------------------------------------------------------------------------------------

    def _position(self, joint: str) -> float:
        names = self._simulation.joint_names
        return float(self._simulation.positions[names.index(joint)]) if joint in names else math.nan

    def _targets(self, joints: Sequence[str]) -> dict[str, float]:
        """Return collision-free targets near the present positions, of joints that have any."""
        specs = [self._joints[name] for name in joints if name in self._joints]
        return free_targets(self._simulation, specs, _STEP)

    def _parameter(self, spec: ControllerSpec, name: str) -> Any:
        node = self._stack.nodes[spec.name]
        return node.get_parameter(name).value if node.has_parameter(name) else None

    def _trajectory(self, spec: ControllerSpec) -> _Act:
        joints = [name for name in self._parameter(spec, "joints") if name in self._joints]
        before = [self._position(name) for name in joints]
        free = self._targets(joints)
        goals = [free.get(name, here) for name, here in zip(joints, before, strict=True)]
        slowest = max(
            (abs(goal - here) / self._joints[name].limits.velocity)
            for name, goal, here in zip(joints, goals, before, strict=True)
        )
        seconds = max(1.0, 3.0 * slowest)
        point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")(positions=goals)
        point.time_from_start.sec = math.ceil(seconds)
        self._send(
            spec,
            "~/joint_trajectory",
            get_message("trajectory_msgs/msg/JointTrajectory")(joint_names=joints, points=[point]),
        )
        yield from self.wait(math.ceil(seconds) + _ARRIVING_S)
        return self._arrived(joints, before, goals)

    def _arrived(
        self, joints: Sequence[str], before: Sequence[float], goals: Sequence[float]
    ) -> tuple[bool, str]:
        after = [self._position(name) for name in joints]
        blocked = [n for n, then, goal in zip(joints, before, goals, strict=True) if goal == then]
        if blocked and len(blocked) == len(joints):
            return False, f"both directions of {', '.join(blocked)} meet the ground or another link"
        still = [
            name
            for name, then, now, goal in zip(joints, before, after, goals, strict=True)
            if name not in blocked and not abs(now - goal) <= (1.0 - ENOUGH) * abs(goal - then)
        ]
        if still:
            summary = (
                f"{len(still)} of {len(joints)} joints do not reach their targets: "
                f"{', '.join(still)}"
            )
            return False, summary + self._standstill_reason(still)
        worst = max((abs(now - goal) for now, goal in zip(after, goals, strict=True)), default=0.0)
        summary = f"{len(joints) - len(blocked)} joints reach their targets, to {worst:.4f}"
        if blocked:
            summary += f"; both directions of {', '.join(blocked)} meet the ground or another link"
        return bool(joints), summary

    def _standstill_reason(self, joints: Sequence[str]) -> str:
        """Return a known reason why joints do not follow their commands; empty for none."""
        names, efforts = self._simulation.joint_names, self._simulation.efforts
        at_limit = []
        for name in joints:
            joint, spec = self._description.joints.get(name), self._joints.get(name)
            if joint is None or spec is None:
                return f"; there is no joint '{name}'"
            limit = spec.limits.effort
            if (friction := joint.dynamics.friction) >= limit:
                return f"; '{name}' has a friction of {friction:g} and an effort of {limit:g}"
            if abs(efforts[names.index(name)]) >= AT_LIMIT * limit:
                at_limit.append(name)
        return f"; at their limits of effort: {', '.join(at_limit)}" if at_limit else ""

    def _gripper(self, spec: ControllerSpec) -> _Act:
        joint = str(self._parameter(spec, "joint"))
        if joint not in self._joints:
            return False, f"there is no joint '{joint}'"
        server = self._stack.action_servers[f"{spec.name}/gripper_cmd"]
        here = self._position(joint)
        goal = self._targets([joint]).get(joint, here)
        request: Any = server.action_type.Goal()
        command = request.command
        if hasattr(command, "name"):
            command.name, command.position = [joint], [goal]
        else:
            command.position, command.max_effort = goal, 0.0
        server.send_goal(request)
        yield from self.wait(MOVING_S + _ARRIVING_S)
        return self._arrived([joint], [here], [goal])

    def _floats(self, spec: ControllerSpec, values: Sequence[float]) -> None:
        message = get_message("std_msgs/msg/Float64MultiArray")(data=values)
        self._send(spec, "~/commands", message)

    def _references(self, spec: ControllerSpec, controller: ChainableControllerInterface) -> _Act:
        """Command the references of a PID controller's first interface, not its derivative."""
        first = controller.reference_interfaces[0].interface_name
        wanted = [one for one in controller.reference_interfaces if one.interface_name == first]

        def send(spec: ControllerSpec, values: Sequence[float]) -> None:
            names = [one.prefix_name.partition("/")[2] for one in wanted]
            kind: Any = get_message("control_msgs/msg/MultiDOFCommand")
            self._send(spec, "~/reference", kind(dof_names=names, values=values))

        return (yield from self._commands(spec, wanted, send))

    def _joint_references(
        self, spec: ControllerSpec, controller: ChainableControllerInterface
    ) -> _Act:
        """Command the positions of an admittance controller's references."""
        wanted = [one for one in controller.reference_interfaces if one.interface_name == POSITION]

        def send(spec: ControllerSpec, values: Sequence[float]) -> None:
            point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")(positions=values)
            self._send(spec, "~/joint_references", point)

        return (yield from self._commands(spec, wanted, send))

    def _commands(
        self,
        spec: ControllerSpec,
        interfaces: Sequence[CommandInterface],
        send: Callable[[ControllerSpec, Sequence[float]], None],
    ) -> _Act:
        joints = [interface.name.split("/")[-2] for interface in interfaces]
        before = [self._position(name) for name in joints]
        sent = [i.interface_name == "position" for i in interfaces]
        free = self._targets([name for name, is_sent in zip(joints, sent, strict=True) if is_sent])
        values = [
            free.get(name, here) if is_sent else self._value(interface, name)
            for interface, name, here, is_sent in zip(interfaces, joints, before, sent, strict=True)
        ]
        send(spec, values)
        yield from self.wait(MOVING_S)
        after = [self._position(name) for name in joints]
        still = [
            name
            for name, interface, then, now, value in zip(
                joints, interfaces, before, after, values, strict=True
            )
            if not abs(now - then) >= self._least(interface, name, value - then, then)
        ]
        stop = [
            now if interface.interface_name == "position" else 0.0
            for interface, now in zip(interfaces, after, strict=True)
        ]
        send(spec, stop)
        if still:
            summary = f"{len(still)} of {len(joints)} joints do not move: {', '.join(still)}"
            return False, summary + self._standstill_reason(still)
        farthest = max(abs(now - then) for now, then in zip(after, before, strict=True))
        return True, f"{len(joints)} joints move, by up to {farthest:.3f}"

    def _value(self, interface: CommandInterface, joint: str) -> float:
        spec = self._joints.get(joint)
        if spec is None:
            return 0.0
        most = spec.limits.effort if interface.interface_name == "effort" else spec.limits.velocity
        if interface.interface_name == "effort":
            return _EFFORT_PART * most if 0.0 < most < math.inf else _EFFORT
        return min(_JOINT_SPEED, most / 2) if most > 0.0 else _JOINT_SPEED

    def _least(self, interface: CommandInterface, joint: str, away: float, before: float) -> float:
        """Return the least motion of a joint that passes; NaN for an unknown joint."""
        if joint not in self._joints:
            return math.nan
        if interface.interface_name == "position":
            return ENOUGH * abs(away)
        if interface.interface_name == "effort":
            return _SOME
        limits = self._joints[joint].limits
        return ENOUGH * min(self._value(interface, joint) * MOVING_S, limits.upper - before)

    # -- bases -------------------------------------------------------------------------------------

    def _base(self, spec: ControllerSpec, topic: str) -> _Act:
        slower = self._slower(spec)
        speed, turn = slower * SPEED, slower * TURN
        in_place = spec.type.rpartition("/")[2] in _IN_PLACE
        if self._base_link is None:
            return False, f"its root link is fixed{self._without_shape(spec)}"
        places = [base_pose(self._simulation, self._base_link)]
        for x, angular in ((speed, 0.0), (0.0 if in_place else speed, turn)):
            yield from self._go(spec, topic, x, angular)
            places.append(base_pose(self._simulation, self._base_link))
        yield from self._go(spec, topic, 0.0, 0.0)
        way = BaseMotion.between(places[0], places[1], places[2], slower)
        summary = way.summary
        if slower < 1.0:
            summary += "; its wheels turn no faster"
        if not way.is_enough:
            summary += self._without_shape(spec)
        if way.is_enough and way.turned < 0.0:
            summary += "; in the opposite direction, as its joints are mounted"
        return way.is_enough, summary

    def _slower(self, spec: ControllerSpec) -> float:
        """Return the fraction of the test velocity that the limits of the wheels permit."""
        radii = [self._parameter(spec, name) for name in _RADII]
        known = [radius for radius in radii if isinstance(radius, float) and radius > 0.0]
        fastest = [self._joints[joint].limits.velocity for joint in self._wheels(spec)]
        if not known or not fastest:
            return 1.0
        return min(1.0, _BELOW_LIMIT * min(fastest) * min(known) / SPEED)

    def _wheels(self, spec: ControllerSpec) -> list[str]:
        """Return the joints that a controller commands by velocity."""
        commanded = [
            interface.name.split("/")[-2]
            for interface in spec.controller.command_interfaces
            if interface.interface_name == "velocity"
        ]
        return [joint for joint in commanded if joint in self._joints]

    def _without_shape(self, spec: ControllerSpec) -> str:
        """Return a clause that names wheels without collision shapes; empty if all have shapes."""
        joints = self._description.joints
        wheels = [joints[name].child for name in self._wheels(spec) if name in joints]
        bare = [link for link in wheels if not self._description.links[link].collisions]
        if not bare:
            return ""
        return f"; without collision shapes, so they cannot collide: {', '.join(bare)}"

    def _go(self, spec: ControllerSpec, topic: str, x: float, turn: float) -> Iterator[None]:
        twist: Any = get_message("geometry_msgs/msg/Twist")()
        twist.linear.x, twist.angular.z = x, turn
        message: Any = twist
        if self._parameter(spec, "use_stamped_vel") is not False:
            message = get_message("geometry_msgs/msg/TwistStamped")(twist=twist)
        for _ in self.wait(MOVING_S):
            # A zero stamp means now, so each command is new: controllers stop on old commands.
            self._send(spec, topic, message)
            yield

    def _send(self, spec: ControllerSpec, topic: str, message: Any) -> None:
        self._stack.nodes[spec.name].receive(topic, message)

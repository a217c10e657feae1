"""Simulation in memory, without a graph: in lockstep with a function, or on recorded commands."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from teleopctl.interfaces import Message, get_message, serialize, set_stamp
from teleopctl.node import Node, Parameter, expand_name
from teleopctl.sim.assembly import assemble, build_robot, declare_parameters
from teleopctl.sim.lockstep import Command, LockstepLoop
from teleopctl.sim.ports import TopicPorts, reported_joints
from teleopctl.sim.simulation import Simulation
from teleopctl.sim.state.saved_state import SavedState
from teleopctl.sim.state.services import put_bodies
from teleopctl.sim.world_markers import WorldMarkers

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

_NODE = "mujoco_sim"


class SimulationReplay:
    """A recorded simulation, run again from its parameters with the recorded commands.

    The simulation is assembled as in `MujocoSim`, from the same parameters, and runs as fast as the
    machine allows.

    Args:
        urdf: The robot description.
        parameters: Parameters of the simulator's node by name; missing ones have their defaults.
        publish: Called with each topic, the simulated time in nanoseconds, and the message's CDR.
        start: State and time from which it runs; None for the simulator's start at time zero.

    Raises:
        RefusedError: The state is of another model.
        InvalidDescriptionError: The robot or the world cannot be simulated.
        InvalidParameterError: A parameter is invalid.
        NotFoundError: The world's file does not exist.

    Attributes:
        topics: Published topics and their types.
        inputs: Topics whose messages move a robot without a controller.
        is_repeating: Whether the present messages repeat those of the same time after a change: a
            simulator publishes them if it is paused.
        control_period_ns: Time between two control ticks, in nanoseconds.
    """

    def __init__(
        self,
        urdf: str,
        parameters: Mapping[str, object],
        publish: Callable[[str, int, bytes], object],
        start: SavedState | None = None,
    ) -> None:
        memory = _MemoryNode(parameters, self._publish)
        # The memory node has the part of a node's interface that is used here.
        node = cast("Node", memory)
        declare_parameters(node)
        self._simulation: Simulation | None = None
        self._save_at: tuple[int, Callable[[SavedState], object]] | None = None
        self.is_repeating = False
        self._take = publish
        robot = build_robot(node, urdf)
        self._simulation = robot.simulation
        if start is not None:
            start.put(robot.simulation, keeps_time=True)
        made = assemble(node, robot)
        self._ports = _AnsweredTopics(made.ports)
        self._loop = made.loop(node, self._ports)
        self._loop.set_real_time_factor(0.0)
        self._loop.set_viewed(True)
        self._loop.set_paused(False, 0.0)
        made.sensors.on_graph_change()
        if start is not None:
            self._loop.go_on()
            made.sensors.go_on(robot.simulation.time_ns)
        WorldMarkers(node, robot.model)
        self.topics: Mapping[str, str] = memory.topics
        self.inputs = {mover.topic for mover in robot.simulation.movers}
        self.control_period_ns = robot.simulation.control_period_ns

    # Any, here and below: messages, whose classes are made at run time.
    def run(
        self,
        commands: Mapping[int, JointState],
        end_ns: int,
        on_tick: Callable[[int], object] = lambda _: None,
        changes: Iterable[tuple[int, Any]] = (),
    ) -> None:
        """Run the simulation from its start to an end time with recorded commands.

        A state without a command had no answer in the recording: the joints hold, as they did then.

        Args:
            commands: Commands by the simulated time, in nanoseconds, of the state that they answer.
            end_ns: Simulated time at which the run ends, in nanoseconds.
            on_tick: Called with the simulated time of each state after it was published.
            changes: Changes by services, each after the simulated time at which it acted, in
                nanoseconds, in ascending order.
        """
        timed = [(time_ns, functools.partial(self._apply, change)) for time_ns, change in changes]
        if self._save_at is not None:
            save_ns, take = self._save_at
            timed.append((save_ns, functools.partial(self._save, take)))
        for time_ns, act in sorted(timed, key=lambda each: each[0]):
            self._loop.call_at(time_ns, act)

        def answer(time_ns: int) -> None:
            on_tick(time_ns)
            command = commands.get(time_ns)
            self._loop.set_controller_present(command is not None)
            if command is not None:
                self._loop.receive_command(_command_of(time_ns, command))
            if time_ns > end_ns:
                self._loop.stop()

        self._ports.on_state = answer
        self._loop.run()

    def save_at(self, time_ns: int, take: Callable[[SavedState], object]) -> None:
        """Pass the state of a simulated time, in nanoseconds, to a function during `run`."""
        self._save_at = time_ns, take

    def _save(self, take: Callable[[SavedState], object]) -> None:
        assert self._simulation is not None
        take(SavedState.of(self._simulation))

    def _apply(self, change: Any) -> None:
        assert self._simulation is not None
        if change.steps:
            # Steps publish their end, whether the loop is paused or not.
            self._loop.step(change.steps, lambda _: None)
            return
        put_bodies(self._simulation, change.free_joints)
        self.is_repeating = True
        self._loop.show(even_running=True)
        self.is_repeating = False

    @property
    def moving_frames(self) -> set[str]:
        """Names of the free bodies' frames, including the robot's root link if it is free."""
        assert self._simulation is not None
        return {body.link for body in self._simulation.free_bodies.bodies}

    def _publish(self, topic: str, data: bytes) -> None:
        self._take(topic, self._simulation.time_ns if self._simulation else 0, data)


def run_in_lockstep(
    simulation: Simulation,
    answer: Callable[[int, JointState], JointState | None],
    goes_on: Callable[[int], bool],
) -> None:
    """Run a simulation at full speed until ``goes_on`` returns false; ``answer`` returns commands.

    Args:
        simulation: Simulation at its start.
        answer: Called with each simulated time, in nanoseconds, and the joint states of that time,
            which are valid during the call; returns the command, or None for no command.
        goes_on: Called with the time of each answered state; returns whether to continue.
    """
    ports = _Ports(simulation, answer, goes_on)
    # No timeout: the command is there before the loop would wait.
    ports.loop = LockstepLoop(simulation, ports, real_time_factor=0.0, lockstep_timeout_s=0.0)
    ports.loop.run()


def _command_of(time_ns: int, command: JointState) -> Command:
    return Command(
        time_ns,
        list(command.name),
        list(command.position),
        list(command.velocity),
        list(command.effort),
    )


class _SilentPorts:
    """Ports without reports, which were made during the recording or follow from the states."""

    def _ignore(self, *_: object, **__: object) -> None:
        """Do nothing."""

    controller_lost = controller_back = fell_behind = _ignore
    diverged = commands_cut = objects_reset = _ignore


class _AnsweredTopics(_SilentPorts):
    """Ports that publish like the simulator's node, and call a function for each state.

    Args:
        topics: Publishers of the simulation.

    Attributes:
        on_state: Called with the time of each state after it was published.
    """

    def __init__(self, topics: TopicPorts) -> None:
        self._topics = topics
        self.publish_clock = topics.publish_clock
        self.publish_view = topics.publish_view
        self.on_state: Callable[[int], object] = lambda _: None

    def publish_state(self, time_ns: int) -> None:
        """Publish the joint states, and call ``on_state``, which passes the recorded command on."""
        self._topics.publish_state(time_ns)
        self.on_state(time_ns)


class _MemoryNode:
    """Part of `Node` that a simulator uses, with given parameters; messages go to a function.

    Args:
        parameters: Values of the parameters by name.
        publish: Called with each topic and the message's CDR.
    """

    def __init__(
        self, parameters: Mapping[str, object], publish: Callable[[str, bytes], object]
    ) -> None:
        self.topics: dict[str, str] = {}
        self._given = parameters
        self._values: dict[str, Parameter] = {}
        self._publish = publish

    def declare_parameter(self, name: str, value: object, descriptor: object = None) -> Parameter:
        del descriptor
        # `Parameter` checks that the value is of one of the nine parameter types.
        self._values[name] = Parameter(name, value=self._given.get(name, value))  # type: ignore[arg-type]
        return self._values[name]

    def get_parameter(self, name: str) -> Parameter:
        return self._values[name]

    def get_logger(self) -> _SilentLog:
        return _SilentLog()

    def create_publisher(
        self, msg_type: type[Message], topic: str, qos: object
    ) -> _MemoryPublisher:
        del qos
        name = expand_name(topic, _NODE, "/")
        self.topics[name] = msg_type.TYPE_NAME
        return _MemoryPublisher(lambda data: self._publish(name, data))


class _MemoryPublisher:
    def __init__(self, publish: Callable[[bytes], object]) -> None:
        self._publish = publish

    def publish(self, message: Message | bytearray) -> None:
        self._publish(bytes(message if isinstance(message, bytearray) else serialize(message)))

    def get_subscription_count(self) -> int:
        return 1


class _SilentLog:
    """Logger that drops all messages: they were logged when the run was recorded."""

    def info(self, message: str, **_: object) -> None:
        pass

    warning = error = info


class _Ports(_SilentPorts):
    """Ports that call a function for each state; see `teleopctl.sim.lockstep.Ports`."""

    loop: LockstepLoop

    def __init__(
        self,
        simulation: Simulation,
        answer: Callable[[int, JointState], JointState | None],
        goes_on: Callable[[int], bool],
    ) -> None:
        self._simulation = simulation
        self._answer = answer
        self._goes_on = goes_on
        self._reported = reported_joints(simulation.model)
        names = [simulation.joint_names[index] for index in self._reported]
        self._state: JointState = get_message("sensor_msgs/msg/JointState")(name=names)

    def publish_state(self, time_ns: int) -> None:
        """Pass the joint states to ``answer``, its command to the loop; stop at the end."""
        state, simulation = self._state, self._simulation
        set_stamp(state.header.stamp, time_ns)
        state.position = simulation.positions[self._reported]
        state.velocity = simulation.velocities[self._reported]
        state.effort = simulation.efforts[self._reported]
        command = self._answer(time_ns, state)
        self.loop.set_controller_present(command is not None)
        if command is not None:
            self.loop.receive_command(_command_of(time_ns, command))
        if not self._goes_on(time_ns):
            self.loop.stop()

    def publish_clock(self, time_ns: int) -> None:
        """Do nothing: a simulation in memory has no /clock."""

    def publish_view(self, time_ns: int) -> None:
        """Do nothing: a simulation in memory has no viewers."""

"""Hardware over two topics: joint states received, joint commands published.

Sensor values are received as positions of joints named like the interfaces: ``imu/orientation.x``.

Simulators and many robots are controlled by these topics. In lockstep, each state is answered by
one command message with the same stamp.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from teleopctl.control.handles import POSITION, CommandInterface, StateInterface
from teleopctl.control.hardware.base import HardwareComponentInterface, HardwareComponentParams
from teleopctl.control.hardware.joint_state_exchange import JOINT_STATE_FIELDS, exchange_of
from teleopctl.control.lifecycle import ReturnType
from teleopctl.errors import HardwareError
from teleopctl.robot import COMMANDS_TOPIC, STATES_TOPIC

_NAN = float("nan")


class JointStateTopicSystem(HardwareComponentInterface):
    """Hardware that receives joint states from a topic and publishes joint commands.

    Plug-in type ``joint_state_topic_hardware_interface/JointStateTopicSystem``.

    Hardware parameters with defaults: ``joint_states_topic`` (``/robot_joint_states``),
    ``joint_commands_topic`` (``/robot_joint_commands``) and ``lockstep`` (true). In lockstep a
    control cycle runs for each received state, else on the wall clock with the last state.
    Components with the same topics share subscription and publisher.
    """

    def __init__(self, params: HardwareComponentParams) -> None:
        super().__init__(params)
        lockstep = self.info.hardware_parameters.get("lockstep") or "true"
        self.drives_cycle = lockstep.strip().lower() != "false"

    def on_init(self) -> None:
        """Read the hardware parameters: topics."""
        parameters = self.info.hardware_parameters
        self._layout: Sequence[str] = ()
        # State interfaces and their places in each field of the messages.
        self._readers: dict[str, list[tuple[StateInterface, int]]] = {}
        self._states_topic = parameters.get("joint_states_topic") or STATES_TOPIC
        self._exchange = exchange_of(
            self.get_node(),
            self._states_topic,
            parameters.get("joint_commands_topic") or COMMANDS_TOPIC,
        )
        commands = self.command_interfaces.values()
        self._names = list(dict.fromkeys(command.prefix_name for command in commands))
        self._columns: list[tuple[str, list[CommandInterface | None]]] = [
            (field, [self.command_interfaces.get(f"{name}/{field}") for name in self._names])
            for field in JOINT_STATE_FIELDS
            if any(command.interface_name == field for command in commands)
        ]
        self._is_full = all(None not in column for _, column in self._columns)

    def set_cycle(self, cycle: Callable[[int], None]) -> None:
        """Store the function that runs a control cycle for each received state, in lockstep."""
        if self.drives_cycle:
            self._exchange.cycle = cycle

    def absence(self) -> str:
        """Return a message if the states' publisher has ended; empty while states can arrive."""
        return self._exchange.absence()

    def on_configure(self) -> None:
        """Reset the states to NaN, and subscribe to joint states."""
        for state in self.state_interfaces.values():
            # The initial value is the start in a simulator, not the robot's present state.
            state.value = _NAN
        self._exchange.open(self)
        self._resets = self._exchange.resets

    def on_activate(self) -> None:
        """Reset the commands to NaN, and create the command publisher."""
        for command in self.command_interfaces.values():
            # The robot may have moved since the last activation: old commands would move it back.
            command.value = _NAN
        self._exchange.activate(self)

    def on_deactivate(self) -> None:
        """Stop publishing commands for the component's joints."""
        self._exchange.deactivate(self)

    def on_cleanup(self) -> None:
        """Unsubscribe from joint states."""
        self._exchange.close(self)

    def on_error(self) -> None:
        """Stop publishing commands, and unsubscribe from joint states."""
        self.on_deactivate()
        self.on_cleanup()

    def prepare_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> None:
        """Raise HardwareError if two controllers would command interfaces of one joint.

        One controller may own several interfaces of a joint, for example position and velocity of
        a trajectory; commands of two controllers would conflict.

        Raises:
            HardwareError: Two controllers would command the same joint.
        """
        for name in start_interfaces:
            wanted = self.command_interfaces[name]
            for other in self.command_interfaces.values():
                if (
                    other.prefix_name != wanted.prefix_name
                    or other.name == name
                    or not {wanted.interface_name, other.interface_name} <= set(JOINT_STATE_FIELDS)
                ):
                    continue
                stays = None if other.name in stop_interfaces else other.owner
                owner = other.next_owner or stays
                if owner not in (None, wanted.next_owner):
                    raise HardwareError(
                        f"'{name}' cannot be commanded while '{owner}' commands '{other.name}': "
                        "one of them has to be inactive"
                    )

    def perform_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> None:
        """Set released commands of joints to NaN when other interfaces of these joints start."""
        joints = {self.command_interfaces[name].prefix_name for name in start_interfaces}
        for name, command in self.command_interfaces.items():
            given_up = command.owner is None or name in stop_interfaces
            if command.prefix_name in joints and name not in start_interfaces and given_up:
                command.value = _NAN

    def read(self, time_ns: int, period: float) -> ReturnType | None:
        """Copy the last received joint state to the state interfaces; detect resets."""
        del time_ns, period
        message = self._exchange.message
        if message is None:
            return None
        if self._resets != self._exchange.resets:
            self._resets = self._exchange.resets
            self.state_jumped = True
        if self._layout != message.name:
            self._lay_out(list(message.name))
        for field, readers in self._readers.items():
            values = getattr(message, field)
            count = len(values)
            for state, index in readers:
                if index < count:
                    state.value = values[index]
        return None

    def _lay_out(self, names: list[str]) -> None:
        """Store the index of each state interface in messages with these joint names."""
        self._layout = names
        index = {name: position for position, name in enumerate(names)}
        self._readers, missing = {field: [] for field in JOINT_STATE_FIELDS}, set()
        for state in self.state_interfaces.values():
            if state.interface_name in JOINT_STATE_FIELDS and state.prefix_name in index:
                self._readers[state.interface_name].append((state, index[state.prefix_name]))
            elif state.name in index:
                # Sensor values are positions of joints named like the interfaces.
                self._readers[POSITION].append((state, index[state.name]))
            elif state.prefix_name not in index:
                missing.add(state.prefix_name)
        if missing:
            self.logger.warning(
                f"No state on {self._states_topic} for: {', '.join(sorted(missing))}"
            )

    def write(self, time_ns: int, period: float) -> None:
        """Mark the component as written; all commands are published after the last component."""
        del period
        self._exchange.write(self, time_ns)

    def commands(self) -> tuple[list[str], dict[str, list[float]]]:
        """Return joint names, and their commands by JointState field; empty if none is claimed."""
        commands = self.command_interfaces.values()
        if self._is_full and None not in [command.owner for command in commands]:
            # The usual case, with as little work as possible: this is called in each cycle.
            return self._names, {
                field: [command.value for command in column if command is not None]
                for field, column in self._columns
            }
        owned = {command.prefix_name for command in commands if command.owner}
        if not owned:
            return [], {}
        return self._names, {
            field: [_value(command, owned) for command in column] for field, column in self._columns
        }


def _value(command: CommandInterface | None, owned: set[str]) -> float:
    """Return the value to publish; NaN for the unclaimed interfaces of a commanded joint.

    A joint without claimed interfaces keeps the last values, so that it holds its position.
    """
    if command is None or (command.owner is None and command.prefix_name in owned):
        return _NAN
    return command.value

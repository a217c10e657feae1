"""Replay of broadcasters, whose messages follow from the recorded joint states."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from teleopctl.control import ControlStack, InterfaceConfigurationType, State
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import AllowableParameterValue, deserialize, get_message, serialize
from teleopctl.node import expand_name

_MANAGER = "controller_manager"


class BroadcasterReplay:
    """Broadcasters of a recorded launch, run again in memory on the bag's joint states.

    Args:
        urdf: Robot description as URDF text.
        parameters: Recorded parameters of all nodes, by full node name and parameter name.
        states_topic: Topic on which the simulator publishes the states of the control ticks.
        period_ns: Time between two ticks, in nanoseconds.
        publish: Called with each topic, the simulated time in nanoseconds, and the message's CDR.

    Attributes:
        topics: Topics on which the broadcasters publish.
        commanding: Full names of the controllers that claim command interfaces and are not run.
        not_run: Reasons why nodes are not run, by full node name.
    """

    def __init__(
        self,
        urdf: str,
        parameters: Mapping[str, Mapping[str, object]],
        states_topic: str,
        period_ns: int,
        publish: Callable[[str, int, bytes], object],
    ) -> None:
        self.topics: set[str] = set()
        self.commanding: list[str] = []
        self.not_run: dict[str, str] = {}
        self._publish = publish
        self._states_topic = states_topic
        self._joint_state = get_message("sensor_msgs/msg/JointState")
        self._stack: ControlStack | None = None
        manager = next((name for name in parameters if name.endswith(f"/{_MANAGER}")), "")
        if not manager:
            return
        self._namespace = manager.removesuffix(_MANAGER).rstrip("/") or "/"
        try:
            self._start(urdf, parameters, manager, round(1e9 / period_ns))
        except TeleopctlError as error:
            self._stack = None
            self.not_run[manager] = f"its hardware cannot be loaded here: {error.message}"

    def update(self, time_ns: int, state: bytes) -> None:
        """Run a control cycle on a JointState (CDR), and publish the broadcasters' messages."""
        stack = self._stack
        if stack is None:
            return
        stack.time_ns = time_ns
        stack.node.receive(self._states_topic, deserialize(state, self._joint_state))
        for name in self._active:
            for endpoint in stack.nodes[name].endpoints.values():
                for message in endpoint.messages:
                    topic = expand_name(endpoint.name, name, self._namespace)
                    self._publish(topic, time_ns, bytes(serialize(message)))
                endpoint.messages = []

    def _start(
        self,
        urdf: str,
        parameters: Mapping[str, Mapping[str, object]],
        manager: str,
        rate_hz: int,
    ) -> None:
        own = _values(parameters[manager])
        stack = ControlStack(update_rate=rate_hz, parameters=own, last_only=True)
        stack.time_ns = 0
        stack.load_urdf(urdf)
        # The states of one component start the cycles, which read and write all components.
        hardware = [component.hardware for component in stack.resources.components.values()]
        cycling = next((each for each in hardware if each.drives_cycle), None)
        if cycling is None or self._states_topic not in stack.node.endpoints:
            self.not_run[manager] = "its hardware does not follow the simulator's states"
            return
        cycling.set_cycle(stack.cycle.run)
        self._stack, self._active = stack, []
        names = [key.removesuffix(".type") for key in own if key.endswith(".type")]
        for name in (name for name in names if "." not in name):
            full_name = expand_name(name, _MANAGER, self._namespace)
            why = self._bring_up(name, _values(parameters.get(full_name, {})))
            if why:
                self.not_run[full_name] = why
                continue
            self._active.append(name)
            self.topics |= {
                expand_name(endpoint.name, name, self._namespace)
                for endpoint in stack.nodes[name].endpoints.values()
                if endpoint.callback is None
            }

    def _bring_up(self, name: str, parameters: Mapping[str, AllowableParameterValue]) -> str:
        """Activate a controller without command interfaces; otherwise return why it is not."""
        assert self._stack is not None
        stack, manager = self._stack, self._stack.manager
        # The update rate counts from the activation, whose time is not recorded: the controller
        # runs at each tick.
        without_rate = {key: each for key, each in parameters.items() if key != "update_rate"}
        stack.set_controller_parameters(name, without_rate)
        before = len(stack.log.lines)
        if not (manager.load_controller(name) and manager.configure_controller(name)):
            said = [text for kind, text in stack.log.lines[before:] if kind == "error"]
            return f"cannot be run here: {said[-1] if said else 'refused'}"
        spec = manager.controllers[name]
        wanted = spec.controller.command_interface_configuration()
        if wanted.type is not InterfaceConfigurationType.NONE:
            self.commanding.append(name)
            return "is commanded from outside: its recorded commands are played back"
        try:
            stack.activate(name)
        except AssertionError as error:
            return f"cannot be run here: {error}"
        return "" if spec.lifecycle_state is State.ACTIVE else "was refused"


def _values(parameters: Mapping[str, object]) -> dict[str, AllowableParameterValue]:
    # YAML values have the types that parameters may have.
    return dict(parameters)  # type: ignore[arg-type]

"""Resource manager: hardware components, their interfaces, and claims on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from teleopctl import plugins
from teleopctl.base.exception_origin import with_origin
from teleopctl.control.asynchronous.hardware import AsyncHardwareComponent
from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.hardware.base import HardwareComponentInterface, HardwareComponentParams
from teleopctl.control.hardware_component import HardwareComponent, RatedHardwareComponent
from teleopctl.control.lifecycle import OnException, ReturnType, State, handle_exception
from teleopctl.control.limits import JointLimiter, limits_text, make_limiter
from teleopctl.errors import BrokenPluginError, HardwareError, UnknownPluginError
from teleopctl.robot import Joints, transmission_has_effect

if TYPE_CHECKING:
    from teleopctl.node import Node, RcutilsLogger
    from teleopctl.robot import HardwareInfo, JointLimits, RobotDescription

# Callback that prepares or performs a command mode switch: interfaces to start, interfaces to stop.
_ModeSwitch = Callable[[Sequence[str], Sequence[str]], ReturnType | None]

_WITHOUT_HARDWARE = (
    "Plug-ins in C++ are not loaded. Without the hardware: hardware:=mock where the description "
    "has that argument, else mock_components/GenericSystem as its <plugin>."
)


class ClaimError(Exception):
    """Raised when an interface cannot be claimed or read; the message says which and why."""


class ResourceManager:
    """Hardware components of a robot, with all state and command interfaces.

    Args:
        node: Node of the controller manager, for hardware that uses topics.
        logger: Logger for messages about hardware.
        report: Function called with a sentence when a command is first clamped.
        update_rate: Update rate of the controller manager in Hz.
        enforce_limits: Whether commands are clamped to the limits of their joints.
        on_exception: Called with each exception of a controller or hardware, after it was logged,
            and with what was logged.

    Attributes:
        on_exception: See above.
        components: Hardware components by name, in the order of the robot description.
        limits: Limits of all joints with one axis, by joint name.
        state_interfaces: State interfaces by full name, in the order of the description.
        command_interfaces: Command interfaces by full name, in the order of the description.
        components_initialized: Whether the hardware of a robot description has been loaded.
        in_lockstep: Whether asynchronous updates run in the control cycle, not in threads.
        in_use: Name of the component whose `read` or `write` was called last in a cycle.
    """

    def __init__(
        self,
        node: Node,
        logger: RcutilsLogger,
        report: Callable[[str], None],
        *,
        update_rate: int,
        enforce_limits: bool,
        on_exception: OnException = handle_exception,
    ) -> None:
        self._node = node
        self.on_exception = on_exception
        self._logger = logger
        self._report = report
        self._update_rate = update_rate
        self._enforce = enforce_limits
        self._limiters: list[JointLimiter] = []
        self._limiter_of: dict[str, JointLimiter] = {}
        self.components: dict[str, HardwareComponent] = {}
        self.limits: dict[str, JointLimits] = {}
        self.state_interfaces: dict[str, StateInterface] = {}
        self.command_interfaces: dict[str, CommandInterface] = {}
        self.components_initialized = False
        self.in_lockstep = True
        self.in_use = ""

    def load_and_initialize_components(self, description: RobotDescription) -> None:
        """Load and initialize all hardware components of a robot description; raise if one fails.

        Raises:
            HardwareError: A plug-in is missing or fails; no component is loaded then.
            InvalidDescriptionError: The description has no ``<ros2_control>``.
        """
        infos = description.require_ros2_control()
        self._logger.info(
            "Enforcing command limits is enabled..."
            if self._enforce
            else "Enforcing command limits is disabled. Command limits from URDF will be ignored."
        )
        components = {info.name: self._make(info) for info in infos}
        for component in components.values():
            hardware = component.hardware
            # The simulator applies those of a robot from an MJCF file.
            if not hardware.applies_transmissions and description.mjcf is None:
                self._report_transmissions(hardware.info, in_simulation=hardware.drives_cycle)
        self.components = components
        self.limits = {name: model.limits for name, model in Joints.of(description).items()}
        for component in components.values():
            self.state_interfaces.update(
                (state.name, state) for state in component.state_interfaces
            )
            self.command_interfaces.update(
                (command.name, command) for command in component.command_interfaces
            )
            self._limit(component)
        self.components_initialized = True

    def _make(self, info: HardwareInfo) -> HardwareComponent:
        plugin = info.hardware_plugin_name
        for warning in info.warnings:
            self._logger.warning(warning)
        self._logger.info(f"Loading hardware '{info.name}' ")
        try:
            hardware_class = plugins.load(plugins.HARDWARE, plugin)
        except UnknownPluginError as error:
            raise HardwareError(
                f"Failed to load hardware '{info.name}': plugin '{plugin}' not found",
                hint=f"{error}\n{_WITHOUT_HARDWARE}",
            ) from error
        except BrokenPluginError as error:
            sentence = f"Failed to load hardware '{info.name}': {error.message}"
            self.on_exception(sentence, error.__cause__ or error)
            raise HardwareError(sentence) from error
        try:
            hardware = hardware_class(
                HardwareComponentParams(info, self._node, self._logger.get_child(info.name))
            )
        except Exception as error:
            sentence = (
                f"Failed to load hardware '{info.name}': plugin '{plugin}' raised "
                f"{with_origin(error)}"
            )
            self.on_exception(sentence, error)
            raise HardwareError(sentence) from error
        self._logger.info(f"Loaded hardware '{info.name}' from plugin '{plugin}'")
        component = self._component(hardware)
        component.on_exception = self.on_exception
        if not component.initialize():
            raise HardwareError(f"Hardware component '{info.name}' failed to initialize")
        return component

    def _report_transmissions(self, info: HardwareInfo, *, in_simulation: bool) -> None:
        """Log which transmissions have no effect, since the hardware commands joints.

        The simulator reports reductions that have no effect, so those of simple transmissions.
        """
        unused = [
            one
            for one in info.transmissions
            if transmission_has_effect(one) and not (in_simulation and len(one.joints) == 1)
        ]
        if unused:
            named = ", ".join(f"'{one.name}' (line {one.line})" for one in unused)
            self._logger.warning(
                f"Transmissions of hardware '{info.name}' have no effect: {named} of the robot "
                f"description. '{info.hardware_plugin_name}' measures and commands joints"
            )

    def _component(self, hardware: HardwareComponentInterface) -> HardwareComponent:
        """Return the component of a plug-in, read and written at the rate of its tag."""
        info, update_rate = hardware.info, self._update_rate
        if info.rw_rate > update_rate:
            self._logger.warning(
                f"Hardware '{info.name}' is read and written at the controller manager's update "
                f"rate, {update_rate} Hz: its rw_rate, {info.rw_rate} Hz, is above that"
            )
        rw_rate = min(info.rw_rate, update_rate) or update_rate
        if hardware.drives_cycle:
            ignored = [f"rw_rate of {rw_rate} Hz"] if rw_rate < update_rate else []
            ignored += ["is_async"] if info.is_async else []
            if ignored:
                self._logger.warning(
                    f"Hardware '{info.name}' is read and written in each control cycle, without "
                    f"its {' and '.join(ignored)}: its states trigger the cycles (lockstep)"
                )
            return HardwareComponent(hardware, self._logger, update_rate)
        if info.is_async:
            return AsyncHardwareComponent(
                hardware, self._logger, update_rate, rw_rate, lambda: not self.in_lockstep
            )
        if rw_rate < update_rate:
            return RatedHardwareComponent(hardware, self._logger, update_rate, rw_rate)
        return HardwareComponent(hardware, self._logger, update_rate)

    def set_lockstep(self, in_lockstep: bool) -> None:
        """Choose between the control cycle and threads for asynchronous hardware and controllers.

        In lockstep, the default, a trigger calls them in the cycle, so that runs repeat exactly.
        """
        self.in_lockstep = in_lockstep
        for component in self.components.values():
            if not component.is_async:
                continue
            if in_lockstep:
                self._logger.info(
                    f"Hardware '{component.name}' is asynchronous in lockstep: the control cycle "
                    "reads and writes it, and values pass one cycle later, so that runs repeat "
                    "exactly"
                )
            else:
                thread = component.hardware.info.async_thread
                policy = "detached" if thread.is_detached else "synchronized"
                self._logger.info(
                    f"Starting async handler of hardware '{component.name}' with scheduler "
                    f"priority: {thread.priority} and policy : {policy}"
                )

    def _limit(self, component: HardwareComponent) -> None:
        joints = dict.fromkeys(command.prefix_name for command in component.command_interfaces)
        for joint in joints:
            limits = self.limits.get(joint)
            if limits is None or not self._enforce:
                continue
            if not limits.enabled:
                self._logger.info(
                    f"Joint limits are disabled for joint '{joint}' in hardware '{component.name}'"
                )
                continue
            name = "JointLimiter" if limits.soft is None else "SoftJointLimiter"
            self._logger.info(
                f"Using {name} for joint '{joint}' in hardware '{component.name}' : "
                f"'{limits_text(limits)}'"
            )
            limiter = make_limiter(
                joint,
                limits,
                {
                    c.interface_name: c
                    for c in component.command_interfaces
                    if c.prefix_name == joint
                },
                {s.interface_name: s for s in component.state_interfaces if s.prefix_name == joint},
                self._report,
            )
            if limiter is not None:
                self._limiters.append(limiter)
                self._limiter_of[joint] = limiter

    def component_of(self, interface: str) -> HardwareComponent | None:
        """Return the hardware component that has an interface; None if none has."""
        for component in self.components.values():
            hardware = component.hardware
            if interface in hardware.command_interfaces or interface in hardware.state_interfaces:
                return component
        return None

    def import_interfaces(
        self, states: Iterable[StateInterface], commands: Iterable[CommandInterface]
    ) -> None:
        """Add the state and reference interfaces that a controller exports."""
        # New mappings, since the control loop may be reading the old ones.
        self.state_interfaces = self.state_interfaces | {state.name: state for state in states}
        self.command_interfaces = self.command_interfaces | {
            command.name: command for command in commands
        }

    def remove_interfaces(
        self, states: Iterable[StateInterface], commands: Iterable[CommandInterface]
    ) -> None:
        """Remove the state and reference interfaces that a controller exported."""
        gone_states = {state.name for state in states}
        gone_commands = {command.name for command in commands}
        self.state_interfaces = {
            name: state for name, state in self.state_interfaces.items() if name not in gone_states
        }
        self.command_interfaces = {
            name: command
            for name, command in self.command_interfaces.items()
            if name not in gone_commands
        }

    def available_states(self, names: Iterable[str]) -> list[StateInterface]:
        """Return the state interfaces of given names; raise if one is not available.

        Raises:
            ClaimError: An interface does not exist or is not available.
        """
        states = []
        for name in names:
            state = self.state_interfaces.get(name)
            if state is None or not state.available:
                raise ClaimError(f"the state interface '{name}' is not available")
            states.append(state)
        return states

    def claim_command_interfaces(self, names: Iterable[str], owner: str) -> list[CommandInterface]:
        """Claim and return command interfaces for a controller: all, or raise and claim none.

        Raises:
            ClaimError: An interface does not exist, is not available or is claimed by another
                controller.
        """
        claimed: list[CommandInterface] = []
        for name in names:
            interface = self.command_interfaces.get(name)
            if interface is None or not interface.available:
                raise ClaimError(f"the command interface '{name}' is not available")
            if interface.owner is not None:
                raise ClaimError(
                    f"the command interface '{name}' is currently claimed by '{interface.owner}'"
                )
            claimed.append(interface)
        for interface in claimed:
            interface.owner = owner
            if (limiter := self._limiter_of.get(interface.prefix_name)) is not None:
                limiter.reset(interface.interface_name)
        return claimed

    def release_command_interfaces(self, owner: str) -> None:
        """Release all command interfaces that a controller has claimed."""
        for interface in self.command_interfaces.values():
            if interface.owner == owner:
                interface.owner = None

    def prepare_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> bool:
        """Prepare hardware for a switch of command interfaces; return whether all of it accepts.

        Args:
            start_interfaces: Full names of interfaces that controllers will claim.
            stop_interfaces: Full names of interfaces that controllers will release.
        """
        return self._switch_command_mode(
            lambda hardware: hardware.prepare_command_mode_switch, start_interfaces, stop_interfaces
        )

    def perform_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> bool:
        """Make hardware components switch command interfaces; return False if one fails."""
        return self._switch_command_mode(
            lambda hardware: hardware.perform_command_mode_switch, start_interfaces, stop_interfaces
        )

    def _switch_command_mode(
        self,
        method: Callable[[HardwareComponentInterface], _ModeSwitch],
        start_interfaces: Sequence[str],
        stop_interfaces: Sequence[str],
    ) -> bool:
        for component in self.components.values():
            hardware = component.hardware
            starting = [name for name in start_interfaces if name in hardware.command_interfaces]
            stopping = [name for name in stop_interfaces if name in hardware.command_interfaces]
            if not starting and not stopping:
                continue
            component.before_mode_switch()
            try:
                outcome = method(hardware)(starting, stopping)
            except Exception as error:  # noqa: BLE001 - a plug-in's failure refuses the switch
                sentence = (
                    f"Hardware '{component.name}' raised in {method(hardware).__name__}: "
                    f"{with_origin(error)}"
                )
                self._logger.error(sentence)
                self.on_exception(sentence, error)
                return False
            component.after_mode_switch()
            if (outcome or ReturnType.OK) is not ReturnType.OK:
                return False
        return True

    def read(self, time_ns: int, period: float) -> list[HardwareComponent]:
        """Read inactive and active hardware; return components that failed or were deactivated."""
        failed = []
        for name, component in self.components.items():
            self.in_use = name
            outcome = component.read(time_ns, period)
            if outcome is not ReturnType.OK:
                failed += [component, *self._deactivate_group(component, outcome)]
        return failed

    def write(self, time_ns: int, period: float) -> list[HardwareComponent]:
        """Write to active hardware; return the components that failed or were deactivated."""
        failed = []
        for name, component in self.components.items():
            self.in_use = name
            outcome = component.write(time_ns, period)
            if outcome is not ReturnType.OK:
                failed += [component, *self._deactivate_group(component, outcome)]
        return failed

    def _deactivate_group(
        self, failed: HardwareComponent, outcome: ReturnType
    ) -> list[HardwareComponent]:
        """Apply a component's ERROR or DEACTIVATE to the others of its group; return these."""
        states = (State.INACTIVE, State.ACTIVE) if outcome is ReturnType.ERROR else (State.ACTIVE,)
        others = [
            other
            for other in self.components.values()
            if other is not failed
            and other.group == failed.group != ""
            and other.lifecycle_state in states
        ]
        for other in others:
            self._logger.error(
                f"Hardware '{other.name}' fails with '{failed.name}', of the same group "
                f"'{failed.group}'"
            )
            other.leave(outcome)
        return others

    def start_components(self, initial: Mapping[str, State]) -> list[tuple[str, State]]:
        """Configure and activate components, or set their initial states; return those that fail.

        Components of a group change together: all are configured before one is activated, and if
        one fails, those already active are deactivated.

        Args:
            initial: States of components that are not to be active, by component name.

        Returns:
            Names of the components that did not reach their state, and these states.
        """
        groups: dict[str, list[HardwareComponent]] = {}
        failed = []
        for name, state in initial.items():
            if name not in self.components:
                self._logger.warning(
                    f"Hardware component '{name}' is unknown, therefore not set in "
                    f"'{state.label}' state. Known are {', '.join(self.components)}"
                )
        for name, component in self.components.items():
            state = initial.get(name, State.ACTIVE)
            if name not in initial and component.group:
                groups.setdefault(component.group, []).append(component)
            elif not component.change_state(state):
                failed.append((name, state))
                self._logger.error(
                    f"Failed to set the initial state of the component : '{name}' to "
                    f"'{state.label}'"
                )
        for group, members in groups.items():
            failed += self._start_group(group, members)
        return failed

    def _start_group(
        self, group: str, members: Sequence[HardwareComponent]
    ) -> list[tuple[str, State]]:
        for target in (State.INACTIVE, State.ACTIVE):
            for component in members:
                if component.change_state(target):
                    continue
                self._logger.error(
                    f"Hardware group '{group}' is not {target.label}, since '{component.name}' "
                    f"is {component.lifecycle_state.label}"
                )
                for other in members:
                    if other.lifecycle_state is State.ACTIVE:
                        other.change_state(State.INACTIVE)
                return [(component.name, target)]
        return []

    def enforce_command_limits(self, period: float) -> None:
        """Clamp the claimed commands to the joints' limits, if limits are enforced."""
        for limiter in self._limiters:
            limiter.enforce(period)

    def take_state_jumped(self) -> bool:
        """Return whether hardware has set ``state_jumped`` since the last call, and clear that."""
        jumped = [component.take_state_jumped() for component in self.components.values()]
        return any(jumped)

    def restart(self) -> None:
        """Reset commands to NaN and restart the limiters, after a reset of the simulation."""
        for limiter in self._limiters:
            limiter.restart()
        for command in self.command_interfaces.values():
            command.value = math.nan

    def shutdown_components(self) -> None:
        """Deactivate and finalize all hardware components."""
        for component in self.components.values():
            if component.lifecycle_state is State.ACTIVE:
                component.change_state(State.INACTIVE)
            component.change_state(State.FINALIZED)

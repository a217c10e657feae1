"""Base class of hardware components, and its constructor argument."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.hardware.transmissions import ActuatorInterfaces
from teleopctl.control.lifecycle import CallbackReturn, ReturnType

if TYPE_CHECKING:
    from teleopctl.node import Node, RcutilsLogger
    from teleopctl.robot import ComponentInfo, HardwareInfo, InterfaceInfo


@dataclass(frozen=True)
class HardwareComponentParams:
    """Constructor argument of hardware components, made by the resource manager.

    Attributes:
        hardware_info: ``<ros2_control>`` tag of the component.
        node: Node of the controller manager, for hardware that uses topics.
        logger: Logger of the component.
    """

    hardware_info: HardwareInfo
    node: Node
    logger: RcutilsLogger


class HardwareComponentInterface:
    """Base class of hardware components, with ros2_control's lifecycle callbacks.

    A plug-in overrides the callbacks that it needs. A lifecycle callback that returns None has
    succeeded, a callback that raises has failed. ``read`` and ``write`` run in the control cycle
    and must not block.

    Args:
        params: Arguments from the resource manager.

    Attributes:
        info: ``<ros2_control>`` tag of the component.
        logger: Logger of the component.
        state_interfaces: State interfaces by full name.
        command_interfaces: Command interfaces by full name.
        drives_cycle: Whether the hardware triggers the control cycles (lockstep) by calling the
            function passed to ``set_cycle``; known before ``on_init``.
        introspected: Functions of the values that `register_introspection` has registered.
        applies_transmissions: Whether ``actuator_interfaces`` was called.
        state_jumped: Set to True by ``read`` when the robot was moved other than by commands, for
            example by a simulation reset: active controllers then discard their plans.
    """

    drives_cycle = False
    state_jumped = False
    applies_transmissions = False
    introspected: Mapping[str, Callable[[], float]] = MappingProxyType({})

    def __init__(self, params: HardwareComponentParams) -> None:
        self.params = params
        self.info = info = params.hardware_info
        self.logger = params.logger
        self.state_interfaces: dict[str, StateInterface] = {}
        self.command_interfaces: dict[str, CommandInterface] = {}
        for part, interface in _interfaces(info, lambda part: part.state_interfaces):
            state = StateInterface(
                part.name, interface.name, interface.data_type, _initial(interface)
            )
            self.state_interfaces[state.name] = state
        for part, interface in _interfaces(info, lambda part: part.command_interfaces):
            command = CommandInterface(
                part.name, interface.name, interface.data_type, _initial(interface)
            )
            self.command_interfaces[command.name] = command
        for command in self.export_unlisted_command_interfaces():
            self.command_interfaces.setdefault(command.name, command)

    def get_node(self) -> Node:
        """Return the controller manager's node."""
        return self.params.node

    def register_introspection(self, name: str, value: Callable[[], float]) -> None:
        """Publish a value on the manager's ``~/introspection_data`` topics while active.

        The counterpart of ros2_control's ``REGISTER_ROS2_CONTROL_INTROSPECTION``.

        Args:
            name: Name of the value, published as ``component.name``.
            value: Function called in each control cycle while the topics have subscribers.
        """
        self.introspected = {**self.introspected, name: value}

    def actuator_interfaces(self) -> ActuatorInterfaces:
        """Return interfaces of the actuators, with the description's ``<transmission>`` tags.

        For ``on_init`` of hardware that measures and commands actuators: its ``read`` sets the
        actuators' states and calls ``actuators_to_joints()``; its ``write`` calls
        ``joints_to_actuators()`` and sends the actuators' commands.

        Raises:
            InvalidDescriptionError: A transmission is of unknown type or has wrong values.
        """
        self.applies_transmissions = True
        return ActuatorInterfaces(self.info, self.state_interfaces, self.command_interfaces)

    def export_unlisted_command_interfaces(self) -> Iterable[CommandInterface]:
        """Return command interfaces that the description does not list; none by default."""
        return ()

    def on_init(self) -> CallbackReturn | None:
        """Called after loading: check the hardware parameters; the base class does nothing."""

    def on_configure(self) -> CallbackReturn | None:
        """Called on configuring: connect, so that states are available; does nothing by default."""

    def on_activate(self) -> CallbackReturn | None:
        """Called on activation: make hardware follow commands; does nothing by default."""

    def on_deactivate(self) -> CallbackReturn | None:
        """Called on deactivation: stop following commands; does nothing by default."""

    def on_cleanup(self) -> CallbackReturn | None:
        """Called on cleanup: disconnect from the hardware; does nothing by default."""

    def on_shutdown(self) -> CallbackReturn | None:
        """Called on finalizing: release all resources; does nothing by default."""

    def on_error(self) -> CallbackReturn | None:
        """Called after ERROR or exceptions; SUCCESS leads to unconfigured, else to finalized."""

    def prepare_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> ReturnType | None:
        """Called before a switch: return ERROR to refuse to switch command interfaces."""

    def perform_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> ReturnType | None:
        """Called in a switch, before controllers are switched: change command modes."""

    def read(self, time_ns: int, period: float) -> ReturnType | None:
        """Called in each cycle if inactive or active: read measured values to ``state_interfaces``.

        Args:
            time_ns: Time of the cycle, nanoseconds.
            period: Seconds since the last cycle.
        """

    def write(self, time_ns: int, period: float) -> ReturnType | None:
        """Called in each cycle if active: write ``command_interfaces`` to the hardware.

        Args:
            time_ns: Time of the cycle, nanoseconds.
            period: Seconds since the last cycle.
        """

    def absence(self) -> str:
        """Called at 2 Hz outside of the cycle: return why no states arrive; empty if they can.

        For hardware that triggers the control cycles: while none come, goals are aborted and
        refused with this sentence, which has no period.
        """
        return ""

    def set_cycle(self, cycle: Callable[[int], None]) -> None:
        """Receive the function to call for a control cycle on each new state; ignored by default.

        Args:
            cycle: Function to call with the time in nanoseconds of each new state, if
                ``drives_cycle`` is True.
        """


def _interfaces(
    info: HardwareInfo, select: Callable[[ComponentInfo], tuple[InterfaceInfo, ...]]
) -> Iterator[tuple[ComponentInfo, InterfaceInfo]]:
    for part in (*info.joints, *info.sensors, *info.gpios):
        for interface in select(part):
            yield part, interface


def _initial(interface: InterfaceInfo) -> float:
    return math.nan if interface.initial_value is None else interface.initial_value

"""Base class of hardware components, and its constructor argument."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType

if TYPE_CHECKING:
    from teleopctl.node import Node, RcutilsLogger
    from teleopctl.robot import ComponentInfo, HardwareInfo, InterfaceInfo


@dataclass(frozen=True)
class HardwareComponentParams:
    """Constructor argument of hardware components, made by the resource manager.

    Attributes:
        hardware_info: The component's ``<ros2_control>`` tag.
        node: The controller manager's node, for hardware that talks over topics.
        logger: The component's logger.
    """

    hardware_info: HardwareInfo
    node: Node
    logger: RcutilsLogger


class HardwareComponentInterface:
    """Base of hardware components, with ros2_control's life cycle callbacks.

    A plug-in overrides what it needs. A life cycle callback that returns None has succeeded; one
    that raises has failed. ``read`` and ``write`` run in the control cycle: they must not block.

    Args:
        params: What the resource manager gives it.

    Attributes:
        info: The component's ``<ros2_control>`` tag.
        logger: The component's logger.
        state_interfaces: State interfaces by full name.
        command_interfaces: Command interfaces by full name.
        drives_cycle: Whether the hardware decides when a control cycle runs (lockstep). Such a
            hardware calls what ``set_cycle`` gives it.
        state_jumped: Set by ``read`` where something else than commands has moved the robot, such
            as the reset of a simulation: controllers give up what they were about to do.
    """

    drives_cycle = False
    state_jumped = False

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
            command = CommandInterface(part.name, interface.name, interface.data_type)
            self.command_interfaces[command.name] = command

    def get_node(self) -> Node:
        """Return the controller manager's node."""
        return self.params.node

    def on_init(self) -> CallbackReturn | None:
        """Check the hardware parameters, once after loading; the base does nothing."""

    def on_configure(self) -> CallbackReturn | None:
        """Connect to the hardware, so that states become available; by default nothing."""

    def on_activate(self) -> CallbackReturn | None:
        """Enable the hardware, which then follows commands; the base does nothing."""

    def on_deactivate(self) -> CallbackReturn | None:
        """Disable the hardware, with states still available; the base does nothing."""

    def on_cleanup(self) -> CallbackReturn | None:
        """Disconnect from the hardware; the base does nothing."""

    def on_shutdown(self) -> CallbackReturn | None:
        """Release all resources, as the last callback; the base does nothing."""

    def on_error(self) -> CallbackReturn | None:
        """Recover from an error; SUCCESS leads to unconfigured, FAILURE to finalized."""

    def prepare_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> ReturnType | None:
        """Check whether command interfaces can be switched; return ERROR to refuse."""

    def perform_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> ReturnType | None:
        """Switch command interfaces, before the controllers are switched."""

    def read(self, time_ns: int, period: float) -> ReturnType | None:
        """Read the measured values into ``state_interfaces``; called in each cycle.

        Args:
            time_ns: Time of the cycle, nanoseconds.
            period: Seconds since the last cycle.
        """

    def write(self, time_ns: int, period: float) -> ReturnType | None:
        """Write the values of ``command_interfaces`` to the hardware; called in each cycle.

        Args:
            time_ns: Time of the cycle, nanoseconds.
            period: Seconds since the last cycle.
        """

    def set_cycle(self, cycle: Callable[[int], None]) -> None:
        """Receive the function that runs a control cycle; the base ignores it.

        Args:
            cycle: To be called for every new state, where ``drives_cycle`` is true.
        """


def _interfaces(
    info: HardwareInfo, select: Callable[[ComponentInfo], tuple[InterfaceInfo, ...]]
) -> Iterator[tuple[ComponentInfo, InterfaceInfo]]:
    for part in (*info.joints, *info.sensors, *info.gpios):
        for interface in select(part):
            yield part, interface


def _initial(interface: InterfaceInfo) -> float:
    return math.nan if interface.initial_value is None else interface.initial_value

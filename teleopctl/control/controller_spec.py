"""Records of loaded controllers in the controller manager."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from teleopctl.control.asynchronous.update import AsyncUpdate
from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.handles import StateInterface
from teleopctl.control.lifecycle import State
from teleopctl.control.statistics import WorkStatistics

_NO_INTERFACES = InterfaceConfiguration()


@dataclass
class ControllerSpec:
    """Record of a loaded controller: type, fallbacks, required interfaces and statistics.

    Attributes:
        controller: Instance of the controller.
        type: Name of the controller's plug-in.
        fallback_controllers: Controllers activated when the controller's update fails.
        command_interface_configuration: Command interfaces to claim; set on configuring.
        state_interface_configuration: State interfaces to read; set on configuring.
        required_command_interfaces: Full names of the command interfaces of that configuration.
        required_state_interfaces: Full names of the state interfaces of that configuration.
        last_update_cycle_time_ns: Time of the last update on the clock that triggers the cycles;
            None before the first update after activation.
        statistics: Statistics of the updates since activation.
        async_update: Updates in a thread of their own; None if the control cycle updates.
        reported_parameters: Parameters that were logged as without effect.
    """

    controller: ControllerInterface
    type: str
    fallback_controllers: tuple[str, ...] = ()
    command_interface_configuration: InterfaceConfiguration = _NO_INTERFACES
    state_interface_configuration: InterfaceConfiguration = _NO_INTERFACES
    required_command_interfaces: tuple[str, ...] = ()
    required_state_interfaces: tuple[str, ...] = ()
    last_update_cycle_time_ns: int | None = None
    statistics: WorkStatistics = field(default_factory=WorkStatistics)
    async_update: AsyncUpdate | None = None
    reported_parameters: set[str] = field(default_factory=set)

    @property
    def name(self) -> str:
        """Name of the controller."""
        return self.controller.name

    @property
    def lifecycle_state(self) -> State:
        """Lifecycle state of the controller."""
        return self.controller.lifecycle_state


def required_names(
    configuration: InterfaceConfiguration, interfaces: Mapping[str, StateInterface]
) -> tuple[str, ...]:
    """Return the interface names that a configuration selects; ALL selects the available ones."""
    if configuration.type is InterfaceConfigurationType.ALL:
        return tuple(name for name, interface in interfaces.items() if interface.available)
    if configuration.type is InterfaceConfigurationType.NONE:
        return ()
    return tuple(configuration.names)


def repeated_name(names: Sequence[str]) -> str | None:
    """Return the first name that occurs twice; None if all differ."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None

"""Passthrough controller: copies references to command interfaces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.control.controllers.base import InterfaceConfiguration, InterfaceConfigurationType
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.handles import CommandInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.interfaces import get_message

if TYPE_CHECKING:
    from teleopctl.node import MessageInfo


class PassthroughController(ChainableControllerInterface):
    """Chainable controller that copies reference interfaces to command interfaces.

    Plug-in type ``passthrough_controller/PassthroughController``, of ros2_control's demonstrations.

    For each of its ``interfaces`` the controller exports a reference of that name, and writes the
    reference's value to the interface. Outside chained mode the references are the data of
    ``~/commands``.
    """

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameter ``interfaces``, and subscribe to ``~/commands``."""
        none: list[str] = []
        self._names: list[str] = self.auto_declare("interfaces", none)
        if not self._names:
            self.logger.error("Parameter 'interfaces' cannot be empty")
            return CallbackReturn.ERROR
        self._command: list[float] | None = None
        self._subscription = self.get_node().create_subscription(
            get_message("std_msgs/msg/Float64MultiArray"), "~/commands", self._received, 10
        )
        return None

    def on_cleanup(self) -> None:
        """Destroy the subscription to ``~/commands``."""
        self.get_node().destroy_subscription(self._subscription)

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces that the parameter ``interfaces`` names."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self._names)

    def on_export_reference_interfaces_list(self) -> list[CommandInterface]:
        """Return a new reference interface, for other controllers, for each command interface."""
        parts = (name.rpartition("/") for name in self._names)
        return [
            CommandInterface(f"{self.name}/{joint}".removesuffix("/"), name)
            for joint, _, name in parts
        ]

    def on_activate(self) -> None:
        """Discard earlier commands, and set the references to NaN."""
        self._command = None
        for reference in self.reference_interfaces:
            reference.value = math.nan

    def on_deactivate(self) -> None:
        """Discard the last received command."""
        self._command = None

    def on_restart(self) -> None:
        """Discard commands and set references to NaN, after a simulation reset."""
        self.on_activate()

    def on_stop(self) -> None:
        """Discard the last received command; commands are refused while the robot is stopped."""
        self._command = None

    def on_release(self) -> None:
        """Do nothing: the references keep their values until the next command."""

    def interfaces_to_decelerate(self) -> Sequence[CommandInterface]:
        """Return the references; none in chained mode, where another controller decelerates."""
        return () if self.in_chained_mode else self.reference_interfaces

    # Any: message classes are generated at run time.
    def _received(self, message: Any, info: MessageInfo) -> None:
        if self.is_refused("The command on ~/commands", info["publisher_gid"]):
            return
        data = [float(value) for value in message.data]
        if len(data) != len(self._names):
            self.logger.error(
                f"Invalid command received of {len(data)} size, expected {len(self._names)} size"
            )
            return
        if not all(map(math.isfinite, data)):
            self.logger.warning("Non-finite value received. Dropping message")
            return
        self._command = data

    def update_reference_from_subscribers(self, time_ns: int, period: float) -> ReturnType | None:
        """Set the reference interfaces to the last command received on ``~/commands``."""
        del time_ns, period
        if self._command is not None:
            for reference, value in zip(self.reference_interfaces, self._command, strict=True):
                reference.value = value
        return None

    def update_and_write_commands(self, time_ns: int, period: float) -> ReturnType | None:
        """Copy references that are not NaN to the command interfaces."""
        del time_ns, period
        for reference, command in zip(
            self.reference_interfaces, self.command_interfaces, strict=True
        ):
            if not math.isnan(reference.value):
                command.value = reference.value
        return None

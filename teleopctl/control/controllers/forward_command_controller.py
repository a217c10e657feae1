"""Forward command controllers: each received command is written at once."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, ClassVar

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType


class ForwardCommandController(ControllerInterface):
    """``forward_command_controller/ForwardCommandController``: one interface of several joints."""

    zero_on_deactivate: ClassVar[bool] = False

    def on_init(self) -> None:
        """Declare the parameters."""
        self.auto_declare("joints", [])
        self.auto_declare("interface_name", "")

    def interface_names(self) -> list[str]:
        """Return the command interfaces, in the order of a message's data."""
        name = self.auto_declare("interface_name", "")
        joints: list[str] = self.auto_declare("joints", [])
        return [f"{joint}/{name}" for joint in joints] if name else []

    def on_configure(self) -> CallbackReturn | None:
        """Subscribe to commands."""
        from teleopctl.interfaces import get_message

        self._names = self.interface_names()
        if not self._names:
            self.logger.error("Parameters that name joints and interfaces cannot be empty")
            return CallbackReturn.ERROR
        self._incoming: deque[list[float]] = deque(maxlen=1)
        self._command: list[float] | None = None
        self._subscription = self.get_node().create_subscription(
            get_message("std_msgs/msg/Float64MultiArray"), "~/commands", self._received, 10
        )
        return None

    def on_cleanup(self) -> None:
        """Unsubscribe from commands."""
        self.get_node().destroy_subscription(self._subscription)

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self._names)

    def on_activate(self) -> None:
        """Drop earlier commands."""
        self._incoming.clear()
        self._command = None

    def on_deactivate(self) -> None:
        """Drop the command; velocity and effort groups stop."""
        self._incoming.clear()
        self._command = None
        if self.zero_on_deactivate:
            for interface in self.command_interfaces:
                interface.value = 0.0

    def on_restart(self) -> None:
        """Drop earlier commands: the simulation was reset."""
        self._command = None

    def _received(self, message: Any) -> None:
        data = [float(value) for value in message.data]
        if not all(map(math.isfinite, data)):
            self.logger.warning("Non-finite value received. Dropping message")
            return
        self._incoming.append(data)

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Write the latest command."""
        del time_ns, period
        if self._incoming:
            self._command = self._incoming.pop()
        command = self._command
        if command is None:
            return None
        if len(command) != len(self.command_interfaces):
            self.logger.error(
                f"command size ({len(command)}) does not match number of interfaces "
                f"({len(self.command_interfaces)})",
                throttle_duration_sec=1.0,
            )
            return ReturnType.ERROR
        for interface, value in zip(self.command_interfaces, command, strict=True):
            interface.value = value
        return None


class MultiInterfaceForwardCommandController(ForwardCommandController):
    """``forward_command_controller/MultiInterfaceForwardCommandController``: one joint."""

    def on_init(self) -> None:
        """Declare the parameters."""
        self.auto_declare("joint", "")
        self.auto_declare("interface_names", [])

    def interface_names(self) -> list[str]:
        """Return the joint's command interfaces."""
        joint = self.auto_declare("joint", "")
        names: list[str] = self.auto_declare("interface_names", [])
        return [f"{joint}/{name}" for name in names] if joint else []


class _JointGroupController(ForwardCommandController):
    """A forward command controller whose interface is fixed."""

    interface: ClassVar[str]

    def on_init(self) -> None:
        """Declare the parameters."""
        self.auto_declare("joints", [])

    def interface_names(self) -> list[str]:
        """Return the joints' command interfaces of the fixed kind."""
        joints: list[str] = self.auto_declare("joints", [])
        return [f"{joint}/{self.interface}" for joint in joints]


class JointGroupPositionController(_JointGroupController):
    """``position_controllers/JointGroupPositionController``."""

    interface = "position"


class JointGroupVelocityController(_JointGroupController):
    """``velocity_controllers/JointGroupVelocityController``."""

    interface = "velocity"
    zero_on_deactivate = True


class JointGroupEffortController(_JointGroupController):
    """``effort_controllers/JointGroupEffortController``."""

    interface = "effort"
    zero_on_deactivate = True

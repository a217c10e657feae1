"""Controller of general-purpose inputs and outputs: the ``<gpio>`` tags of ros2_control."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from itertools import islice
from typing import Any

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.handles import CommandInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher, realtime_log
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, set_stamp
from teleopctl.robot import RobotDescription

_NONE: list[str] = []


class GpioCommandController(ControllerInterface):
    """Controller that writes ``~/commands`` to GPIOs and publishes ``~/gpio_states``.

    Plug-in type ``gpio_controllers/GpioCommandController``.

    Without ``state_interfaces`` it publishes all state interfaces that the robot description has
    for its ``gpios``; without ``command_interfaces`` it only publishes.
    """

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the subscription and the publisher."""
        self._gpios: list[str] = self.auto_declare("gpios", _NONE, read_only=True)
        if not self._gpios:
            self.logger.error("Parameter 'gpios' cannot be empty")
            return CallbackReturn.ERROR
        try:
            commands = self._read_interfaces("command_interfaces")
            states = self._read_interfaces("state_interfaces")
        except ValueError as error:
            self.logger.error(str(error))
            return CallbackReturn.ERROR
        if not any(states.values()):
            self.logger.info(
                "State interfaces are not configured. All available interfaces of configured GPIOs "
                "will be broadcasted."
            )
            states = self._described_states()
        self._commands, self._states = _full_names(commands), _full_names(states)
        if not self._commands and not self._states:
            self.logger.error("No command or state interfaces are configured")
            return CallbackReturn.ERROR
        self._place = {name: number for number, name in enumerate(self._commands)}
        self._open(states)
        self.logger.info("configure successful")
        return None

    def _read_interfaces(self, kind: str) -> dict[str, list[str]]:
        """Return the parameter ``<kind>.<gpio>.interfaces`` of each GPIO."""
        if len(set(self._gpios)) != len(self._gpios):
            raise ValueError("Value of parameter 'gpios' must be unique")
        found: dict[str, list[str]] = {}
        for gpio in self._gpios:
            parameter = f"{kind}.{gpio}.interfaces"
            found[gpio] = self.auto_declare(parameter, _NONE, read_only=True)
            if len(set(found[gpio])) != len(found[gpio]):
                raise ValueError(f"Value of parameter '{parameter}' must be unique")
        return found

    def _described_states(self) -> dict[str, list[str]]:
        """Return the state interfaces that the robot description has for each GPIO."""
        found: dict[str, list[str]] = {gpio: [] for gpio in self._gpios}
        try:
            components = RobotDescription.from_urdf(self.params.robot_description).ros2_control
        except TeleopctlError as error:
            self.logger.error(f"The GPIOs of the robot description cannot be read: {error}")
            return found
        for component in components:
            for gpio in component.gpios:
                if gpio.name in found:
                    found[gpio.name].extend(state.name for state in gpio.state_interfaces)
        return found

    def _open(self, states: dict[str, list[str]]) -> None:
        node, queue = self.get_node(), self.params.publish_queue
        # Any: message classes are generated at run time. The message is reused.
        kind: Any = get_message("control_msgs/msg/DynamicInterfaceGroupValues")
        values: Any = get_message("control_msgs/msg/InterfaceValue")
        self._incoming: deque[list[tuple[int, float]] | str] = deque(maxlen=1)
        self._command: list[tuple[int, float]] = []
        self._subscription: Any = None
        if self._commands:
            self._subscription = node.create_subscription(kind, "~/commands", self._received, 10)
        self._message: Any = kind(
            interface_groups=list(states),
            interface_values=[
                values(interface_names=list(names), values=[math.nan] * len(names))
                for names in states.values()
            ],
        )
        self._publisher = node.create_publisher(kind, "~/gpio_states", 10)
        self._realtime = RealtimePublisher(queue, self._publish)
        self._log = realtime_log(queue)

    def on_cleanup(self) -> None:
        """Destroy the subscription and the publisher."""
        if self._subscription is not None:
            self.get_node().destroy_subscription(self._subscription)
        self.get_node().destroy_publisher(self._publisher)

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces that the parameters name."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self._commands)

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces that the parameters name, else those of the description."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self._states)

    def on_activate(self) -> None:
        """Discard commands that were received earlier."""
        self._forget()
        self.logger.info("activate successful")

    def on_release(self) -> None:
        """Do nothing: outputs keep following commands while the robot is stopped."""

    def interfaces_to_decelerate(self) -> Sequence[CommandInterface]:
        """Return none: outputs are no motion."""
        return ()

    def on_deactivate(self) -> None:
        """Discard the last command; the outputs keep it."""
        self._forget()

    def on_restart(self) -> None:
        """Discard the last command after a simulation reset."""
        self._forget()

    def _forget(self) -> None:
        self._incoming.clear()
        self._command = []

    # Any: message classes are generated at run time.
    def _received(self, message: Any) -> None:
        """Keep a message as pairs of an interface's place and value; or the text of its mistake."""
        groups, given = list(message.interface_groups), list(message.interface_values)
        if len(groups) != len(given):
            self.logger.error(
                f"Invalid command received of {len(groups)} interface_groups and {len(given)} "
                "interface_values. Dropping message"
            )
            return
        command: list[tuple[int, float]] = []
        for gpio, one in zip(groups, given, strict=True):
            if len(one.interface_names) != len(one.values):
                self._incoming.append(f"For gpio {gpio} interfaces_names do not match values")
                return
            for name, value in zip(one.interface_names, one.values, strict=True):
                place = self._place.get(f"{gpio}/{name}")
                if place is None:
                    self.logger.warning(
                        f"'{gpio}/{name}' is not one of the command interfaces "
                        f"({', '.join(self._commands)}). Ignoring its value",
                        throttle_duration_sec=1.0,
                    )
                elif not math.isfinite(value):
                    self.logger.warning("Non-finite value received. Dropping message")
                    return
                else:
                    command.append((place, float(value)))
        self._incoming.append(command)

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Queue the states for publishing; write the last command, return ERROR for a wrong one."""
        del period
        self._realtime.try_publish((time_ns, [state.value for state in self.state_interfaces]))
        if self._incoming:
            command = self._incoming.pop()
            if isinstance(command, str):
                self._log.try_publish((self.logger.error, command))
                return ReturnType.ERROR
            self._command = command
        interfaces = self.command_interfaces
        for place, value in self._command:
            interfaces[place].value = value
        return None

    def _publish(self, value: tuple[int, Sequence[float]]) -> None:
        time_ns, values = value
        numbers = iter(values)
        for group in self._message.interface_values:
            group.values = list(islice(numbers, len(group.interface_names)))
        set_stamp(self._message.header.stamp, time_ns)
        self._publisher.publish(self._message)


def _full_names(interfaces: dict[str, list[str]]) -> list[str]:
    return [f"{gpio}/{name}" for gpio, names in interfaces.items() for name in names]

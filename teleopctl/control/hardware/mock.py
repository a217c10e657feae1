"""Mock hardware: commands become the measured values of the next cycle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from teleopctl.control.handles import (
    ACCELERATION,
    EFFORT,
    POSITION,
    VELOCITY,
    CommandInterface,
    StateInterface,
)
from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.control.lifecycle import ReturnType
from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import to_number


def parse_bool(text: str | None) -> bool:
    """Return whether the text of a hardware parameter is ``true``."""
    return (text or "").strip().lower() == "true"


_DYNAMICS = (POSITION, VELOCITY, ACCELERATION)
# Standard interfaces of ros2_control; others are custom ones.
_STANDARD = (*_DYNAMICS, EFFORT)


class GenericSystem(HardwareComponentInterface):
    """Mock hardware that copies commands to states, as ros2_control's GenericSystem.

    Plug-in type ``mock_components/GenericSystem``.

    Hardware parameters: ``calculate_dynamics``, ``position_state_following_offset``,
    ``custom_interface_with_following_offset``, ``disable_commands``, ``mock_sensor_commands``,
    ``mock_gpio_commands``.
    """

    def on_init(self) -> None:
        """Read the hardware parameters, and pair command with state interfaces by name.

        Raises:
            InvalidDescriptionError: ``position_state_following_offset`` is no number.
        """
        parameters = self.info.hardware_parameters
        self._disabled = parse_bool(parameters.get("disable_commands"))
        self._dynamics = parse_bool(parameters.get("calculate_dynamics"))
        text = parameters.get("position_state_following_offset") or "0"
        offset = to_number(text)
        if offset is None:
            raise InvalidDescriptionError(
                f"Hardware '{self.info.name}': position_state_following_offset should be a "
                f"number, got '{text}'"
            )
        custom = parameters.get("custom_interface_with_following_offset") or ""
        self._position_offset = 0.0 if custom else offset
        self._is_configured = False
        self._speeds: dict[str, float] = {}
        joints = {joint.name for joint in self.info.joints}
        # By joint, the quantity that is commanded while its dynamics are calculated.
        self._modes = {
            joint: POSITION
            for joint in joints
            if self._dynamics and f"{joint}/{POSITION}" in self.state_interfaces
        }
        self._pairs = [
            (command, state, self._offset_of(command) if state.prefix_name in joints else 0.0)
            for name, command in self.command_interfaces.items()
            if (state := self.state_interfaces.get(name)) is not None
            and not (state.prefix_name in self._modes and state.interface_name in _DYNAMICS)
        ]
        self._joint_states = [
            state for state in self.state_interfaces.values() if state.prefix_name in joints
        ]
        self._customs = self._with_custom_offset(custom, offset)
        self._followers = self._mimics()

    def export_unlisted_command_interfaces(self) -> Iterable[CommandInterface]:
        """Return a command for each sensor and GPIO state, as the ``mock_`` parameters choose."""
        parameters = self.info.hardware_parameters
        chosen = (
            ("mock_sensor_commands", self.info.sensors),
            ("mock_gpio_commands", self.info.gpios),
        )
        return [
            CommandInterface(
                part.name,
                state.name,
                state.data_type,
                math.nan if state.initial_value is None else state.initial_value,
            )
            for parameter, parts in chosen
            if parse_bool(parameters.get(parameter))
            for part in parts
            for state in part.state_interfaces
        ]

    def _offset_of(self, command: CommandInterface) -> float:
        return self._position_offset if command.interface_name == POSITION else 0.0

    def _with_custom_offset(
        self, interface: str, offset: float
    ) -> list[tuple[CommandInterface, StateInterface, float]]:
        """Return position commands and the states of a custom interface that follow with offset."""
        if not interface:
            return []
        pairs = [
            (command, state, offset)
            for command in self.command_interfaces.values()
            if command.interface_name == POSITION
            and (state := self.state_interfaces.get(f"{command.prefix_name}/{interface}"))
            is not None
        ]
        if pairs and interface not in _STANDARD:
            self.logger.info(f"Custom interface with following offset '{interface}' found.")
            return pairs
        self.logger.warning(
            f"Custom interface with following offset '{interface}' does not exist. Offset will "
            "not be applied"
        )
        return []

    def _mimics(self) -> list[tuple[StateInterface, StateInterface, float, float]]:
        """Return mimic joints' states with their leaders' states, factors and offsets."""
        followers: list[tuple[StateInterface, StateInterface, float, float]] = []
        for joint in self.info.joints:
            mimic = joint.mimic
            if mimic is None:
                continue
            for quantity in _DYNAMICS:
                follower = self.state_interfaces.get(f"{joint.name}/{quantity}")
                leader = self.state_interfaces.get(f"{mimic.joint}/{quantity}")
                if follower is not None and leader is not None:
                    offset = mimic.offset if quantity == POSITION else 0.0
                    followers.append((follower, leader, mimic.multiplier, offset))
        return followers

    def on_configure(self) -> None:
        """Set NaN joint states to zero, NaN positions to the resting position within the limits."""
        rest = {joint.name: joint.limits.rest for joint in self.info.joints}
        for state in self._joint_states:
            is_position = state.interface_name == POSITION
            if math.isnan(state.value):
                state.value = rest[state.prefix_name] if is_position else 0.0
            if is_position and not self._is_configured:
                state.value += self._position_offset
        self._is_configured = True
        self._follow()

    def prepare_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> ReturnType | None:
        """With dynamics, return ERROR unless each joint gets one of its three quantities."""
        del stop_interfaces
        for joint, quantities in self._started(start_interfaces).items():
            if not quantities:
                self.logger.error(
                    f"Joint '{joint}' has to have '{POSITION}', '{VELOCITY}', or '{ACCELERATION}' "
                    "interface!"
                )
                return ReturnType.ERROR
            if len(quantities) > 1:
                self.logger.error(
                    f"Got multiple ({len(quantities)}) starting interfaces for joint '{joint}' - "
                    "this is not supported! With 'calculate_dynamics' one of "
                    f"{', '.join(quantities)} is commanded"
                )
                return ReturnType.ERROR
        return None

    def perform_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> None:
        """With dynamics, set the quantity by which each joint is commanded from now on."""
        for name in stop_interfaces:
            joint, _, quantity = name.rpartition("/")
            if self._modes.get(joint) == quantity != POSITION:
                # No controller commands the joint any more, so it stops.
                self._modes[joint] = POSITION
                self._stop(joint)
        for joint, quantities in self._started(start_interfaces).items():
            if quantities and joint in self._modes:
                self._modes[joint] = quantities[0]

    def _started(self, start_interfaces: Sequence[str]) -> dict[str, list[str]]:
        """Return the dynamic quantities among the started interfaces, by joint with dynamics."""
        started: dict[str, list[str]] = {}
        for name in start_interfaces:
            joint, _, quantity = name.rpartition("/")
            if joint in self._modes:
                quantities = started.setdefault(joint, [])
                if quantity in _DYNAMICS:
                    quantities.append(quantity)
        return started

    def _stop(self, joint: str) -> None:
        position = self.command_interfaces.get(f"{joint}/{POSITION}")
        if position is not None:
            # A position commanded earlier would move the joint back.
            position.value = math.nan
        self._speeds.pop(joint, None)
        for quantity in (VELOCITY, ACCELERATION):
            if (state := self.state_interfaces.get(f"{joint}/{quantity}")) is not None:
                state.value = 0.0

    def read(self, time_ns: int, period: float) -> ReturnType | None:
        """Copy commands to states; with dynamics, compute each joint's other quantities too."""
        del time_ns
        if self._disabled:
            self.logger.warning(
                "Command propagation is disabled - no values will be returned!",
                throttle_duration_sec=10.0,
            )
            return None
        for joint, mode in self._modes.items():
            if not self._move(joint, mode, period):
                return ReturnType.ERROR
        for command, state, offset in self._pairs:
            value = command.value
            if value - value == 0.0:
                state.value = value + offset
            elif value == value:
                return ReturnType.ERROR
        for command, state, offset in self._customs:
            if math.isfinite(command.value):
                state.value = command.value + offset
        self._follow()
        return None

    def _move(self, joint: str, mode: str, period: float) -> bool:
        """Compute a joint's state from the command of one quantity; return False if infinite.

        Velocity and acceleration are differentiated or integrated (backward Euler): the velocity
        at the end of the period applies during the period.
        """
        found = self.command_interfaces.get(f"{joint}/{mode}")
        command = math.nan if found is None else found.value
        if math.isinf(command):
            return False
        if math.isnan(command) or period <= 0.0:
            return True
        states = self.state_interfaces
        position = states[f"{joint}/{POSITION}"]
        velocity = states.get(f"{joint}/{VELOCITY}")
        acceleration = states.get(f"{joint}/{ACCELERATION}")
        last_velocity = self._speeds.get(joint, 0.0)
        if mode == POSITION:
            new_position = command + self._position_offset
            new_velocity = (new_position - position.value) / period
        else:
            step = command * period if mode == ACCELERATION else command - last_velocity
            new_velocity = last_velocity + step
            new_position = position.value + new_velocity * period
        self._speeds[joint] = new_velocity
        position.value = new_position
        if velocity is not None:
            velocity.value = new_velocity
        if acceleration is not None:
            acceleration.value = (new_velocity - last_velocity) / period
        return True

    def _follow(self) -> None:
        for follower, leader, multiplier, offset in self._followers:
            follower.value = multiplier * leader.value + offset

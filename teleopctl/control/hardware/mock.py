"""Mock hardware: commands become the measured values of the next cycle."""

from __future__ import annotations

import math
from collections.abc import Sequence

from teleopctl.control.handles import (
    ACCELERATION,
    POSITION,
    VELOCITY,
    CommandInterface,
    StateInterface,
)
from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.control.lifecycle import ReturnType


def parse_bool(text: str | None) -> bool:
    """Return whether the text of a hardware parameter is ``true``."""
    return (text or "").strip().lower() == "true"


class GenericSystem(HardwareComponentInterface):
    """Mock hardware that copies commands to states, as ros2_control's GenericSystem.

    Plug-in type ``mock_components/GenericSystem``.

    Hardware parameters: ``calculate_dynamics``, ``position_state_following_offset``,
    ``custom_interface_with_following_offset``, ``disable_commands``.
    """

    def on_init(self) -> None:
        """Read the hardware parameters, and pair command with state interfaces by name."""
        parameters = self.info.hardware_parameters
        self._disabled = parse_bool(parameters.get("disable_commands"))
        self._dynamics = parse_bool(parameters.get("calculate_dynamics"))
        self._offset = float(parameters.get("position_state_following_offset") or 0.0)
        self._offset_interface = parameters.get("custom_interface_with_following_offset") or ""
        self._modes: dict[str, str] = {}
        self._last: dict[str, tuple[float, float]] = {}
        self._pairs = [
            (command, state, self._offset_of(command))
            for name, command in self.command_interfaces.items()
            if (state := self.state_interfaces.get(name)) is not None
        ]
        names = {joint.name for joint in self.info.joints}
        self._joint_states = [
            state for state in self.state_interfaces.values() if state.prefix_name in names
        ]
        followers: list[tuple[StateInterface, StateInterface, float, float]] = []
        for joint in self.info.joints:
            mimic = joint.mimic
            if mimic is None:
                continue
            for quantity in (POSITION, VELOCITY, ACCELERATION):
                follower = self.state_interfaces.get(f"{joint.name}/{quantity}")
                leader = self.state_interfaces.get(f"{mimic.joint}/{quantity}")
                if follower is not None and leader is not None:
                    offset = mimic.offset if quantity == POSITION else 0.0
                    followers.append((follower, leader, mimic.multiplier, offset))
        self._followers = followers

    def _offset_of(self, command: CommandInterface) -> float:
        if self._offset_interface:
            return 0.0
        return self._offset if command.interface_name == POSITION else 0.0

    def on_configure(self) -> None:
        """Set NaN joint states to zero, NaN positions to the resting position within the limits."""
        rest = {joint.name: joint.limits.rest for joint in self.info.joints}
        for state in self._joint_states:
            if math.isnan(state.value):
                state.value = rest[state.prefix_name] if state.interface_name == POSITION else 0.0
            if state.interface_name == POSITION:
                self._last.setdefault(state.prefix_name, (state.value, 0.0))
        self._follow()

    def prepare_command_mode_switch(
        self, start_interfaces: Sequence[str], stop_interfaces: Sequence[str]
    ) -> ReturnType | None:
        """With dynamics, return ERROR if a joint would be commanded by two interfaces at once."""
        if not self._dynamics:
            return None
        modes = dict(self._modes)
        for name in stop_interfaces:
            modes.pop(name.rpartition("/")[0], None)
        seen: dict[str, str] = {}
        for name in start_interfaces:
            joint, _, quantity = name.rpartition("/")
            if quantity not in (POSITION, VELOCITY, ACCELERATION):
                continue
            if joint in seen:
                self.logger.error(
                    f"Joint '{joint}' cannot be commanded by {seen[joint]} and {quantity} at once "
                    "while 'calculate_dynamics' is on."
                )
                return ReturnType.ERROR
            seen[joint] = quantity
        self._modes = {**modes, **seen}
        return None

    def read(self, time_ns: int, period: float) -> ReturnType | None:
        """Copy commands to states; with dynamics, compute each joint's other quantities too."""
        del time_ns
        if self._disabled:
            self.logger.warning(
                "Command propagation is disabled: no values will be returned!",
                throttle_duration_sec=10.0,
            )
            return None
        for command, state, offset in self._pairs:
            value = command.value
            if value - value == 0.0:
                state.value = value + offset
            elif value == value:
                return ReturnType.ERROR
        if self._offset_interface:
            self._apply_custom_offset()
        if self._dynamics:
            for joint, mode in self._modes.items():
                self._move(joint, mode, period)
        self._follow()
        return None

    def _apply_custom_offset(self) -> None:
        for command, _, _ in self._pairs:
            state = self.state_interfaces.get(f"{command.prefix_name}/{self._offset_interface}")
            if (
                command.interface_name == POSITION
                and state is not None
                and math.isfinite(command.value)
            ):
                state.value = command.value + self._offset

    def _move(self, joint: str, mode: str, period: float) -> None:
        """Compute a joint's state from the command of one quantity."""
        position = self.state_interfaces.get(f"{joint}/{POSITION}")
        velocity = self.state_interfaces.get(f"{joint}/{VELOCITY}")
        acceleration = self.state_interfaces.get(f"{joint}/{ACCELERATION}")
        command = self.command_interfaces[f"{joint}/{mode}"].value
        if not math.isfinite(command) or position is None or period <= 0.0:
            return
        last_position, last_velocity = self._last[joint]
        if mode == POSITION:
            new_position = command
            new_velocity = (command - last_position) / period
            new_acceleration = (new_velocity - last_velocity) / period
        elif mode == VELOCITY:
            new_velocity = command
            new_position = last_position + command * period
            new_acceleration = (command - last_velocity) / period
        else:
            new_acceleration = command
            new_velocity = last_velocity + command * period
            new_position = last_position + new_velocity * period
        self._last[joint] = (new_position, new_velocity)
        position.value = new_position + (self._offset if mode == POSITION else 0.0)
        if velocity is not None:
            velocity.value = new_velocity
        if acceleration is not None:
            acceleration.value = new_acceleration

    def _follow(self) -> None:
        for follower, leader, multiplier, offset in self._followers:
            follower.value = multiplier * leader.value + offset

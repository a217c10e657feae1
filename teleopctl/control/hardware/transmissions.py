"""Actuators of hardware, connected to its joints by ``<transmission>`` tags."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.robot import SimpleTransmission, Transmission, ends_by_role, make_transmission

if TYPE_CHECKING:
    from teleopctl.robot import HardwareInfo


class ActuatorInterfaces:
    """Interfaces of a component's actuators, which transmissions connect to those of its joints.

    A joint without a transmission has an actuator of the same name and values.

    Args:
        info: ``<ros2_control>`` tag of the component.
        states: State interfaces of the component by full name.
        commands: Command interfaces of the component by full name.

    Attributes:
        states: Measured values by full name, such as ``motor1/position``; the hardware's ``read``
            sets them.
        commands: Commands by full name; the hardware's ``write`` sends them.

    Raises:
        InvalidDescriptionError: As for `make_transmission`.
    """

    def __init__(
        self,
        info: HardwareInfo,
        states: Mapping[str, StateInterface],
        commands: Mapping[str, CommandInterface],
    ) -> None:
        self.states: dict[str, StateInterface] = {}
        self.commands: dict[str, CommandInterface] = {}
        # Transmission, quantity, and interfaces whose values it reads and writes.
        self._to_joints: list[
            tuple[Transmission, str, list[StateInterface], list[StateInterface]]
        ] = []
        self._to_actuators: list[
            tuple[Transmission, str, list[CommandInterface], list[CommandInterface]]
        ] = []
        connected: list[tuple[Transmission, list[str], list[str]]] = []
        for one in info.transmissions:
            joints = [end.name for end in ends_by_role(one.joints)]
            actuators = [end.name for end in ends_by_role(one.actuators)]
            connected.append((make_transmission(one), joints, actuators))
        moved = {joint for _, joints, _ in connected for joint in joints}
        direct = SimpleTransmission((1.0,), (1.0,), (0.0,))
        connected += [(direct, [j.name], [j.name]) for j in info.joints if j.name not in moved]
        for transmission, joints, actuators in connected:
            for quantity in transmission.quantities:
                measured = [states.get(f"{joint}/{quantity}") for joint in joints]
                if all(state is not None for state in measured):
                    own = [StateInterface(actuator, quantity) for actuator in actuators]
                    self.states.update((state.name, state) for state in own)
                    ends = [state for state in measured if state is not None]
                    self._to_joints.append((transmission, quantity, own, ends))
                wanted = [commands.get(f"{joint}/{quantity}") for joint in joints]
                if all(command is not None for command in wanted):
                    given = [CommandInterface(actuator, quantity) for actuator in actuators]
                    self.commands.update((command.name, command) for command in given)
                    sources = [command for command in wanted if command is not None]
                    self._to_actuators.append((transmission, quantity, sources, given))

    def actuators_to_joints(self) -> None:
        """Compute the joints' states from those of the actuators; for the end of ``read``."""
        for transmission, quantity, actuators, joints in self._to_joints:
            values = transmission.actuator_to_joint(quantity, [one.value for one in actuators])
            for joint, value in zip(joints, values, strict=True):
                if not math.isnan(value):
                    joint.value = value

    def joints_to_actuators(self) -> None:
        """Compute the actuators' commands from those of the joints; for the start of ``write``."""
        for transmission, quantity, joints, actuators in self._to_actuators:
            values = transmission.joint_to_actuator(quantity, [one.value for one in joints])
            for actuator, value in zip(actuators, values, strict=True):
                actuator.value = value

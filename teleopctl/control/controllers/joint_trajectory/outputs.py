"""Command interfaces of a joint trajectory controller."""

from __future__ import annotations

import math
from collections.abc import Sequence

from teleopctl.control.controllers.joint_trajectory.settings import TrajectorySettings
from teleopctl.control.controllers.joint_trajectory.trajectory import TrajectoryPoint
from teleopctl.control.controllers.pid import Pid
from teleopctl.control.handles import (
    ACCELERATION,
    EFFORT,
    POSITION,
    VELOCITY,
    CommandInterface,
)


class CommandOutputs:
    """Command interfaces of a joint trajectory controller, written directly or through PIDs.

    Args:
        settings: Settings of the controller.
        interfaces: Claimed command interfaces, joint by joint, each with all quantities.
        pids: PID of each joint of the trajectories; used if PIDs compute the commands.
    """

    def __init__(
        self,
        settings: TrajectorySettings,
        interfaces: Sequence[CommandInterface],
        pids: Sequence[Pid],
    ) -> None:
        count = len(settings.command_interfaces)
        self._outputs = {
            name: list(interfaces[index::count])
            for index, name in enumerate(settings.command_interfaces)
        }
        self._pids = pids
        self._uses_pid = settings.uses_pid
        self._joints = settings.commanded_indices
        self._all_commanded = len(self._joints) == len(settings.joints)

    def positions(self) -> list[float] | None:
        """Return the commanded positions; None unless every joint has a finite one."""
        outputs = self._outputs.get(POSITION)
        if not outputs or not self._all_commanded:
            return None
        values = [output.value for output in outputs]
        return values if all(map(math.isfinite, values)) else None

    def values(self) -> dict[str, list[float]]:
        """Return the command values of the joints, as lists by interface name such as position."""
        return {name: [o.value for o in outputs] for name, outputs in self._outputs.items()}

    def zero_commands(self) -> None:
        """Command zero on all command interfaces except positions."""
        for name, outputs in self._outputs.items():
            if name != POSITION:
                for output in outputs:
                    output.value = 0.0

    def write(
        self,
        state: TrajectoryPoint,
        effort: Sequence[float],
        errors: Sequence[float],
        velocity_errors: Sequence[float],
        period: float,
    ) -> None:
        """Write a trajectory's state, or PID outputs for its errors, to the command interfaces.

        Args:
            state: State of the trajectory at the next update.
            effort: Efforts of the trajectory now, beside commanded positions; may be empty.
            errors: Desired minus measured position of each joint.
            velocity_errors: Desired minus measured velocity of each joint, or empty.
            period: Seconds since the last update.
        """
        for name, values in (
            (POSITION, state.positions),
            (ACCELERATION, state.accelerations),
            (VELOCITY, state.velocities),
            (EFFORT, effort),
        ):
            interfaces = self._outputs.get(name)
            if interfaces is None:
                continue
            if self._uses_pid:
                self._write_pid(name, interfaces, state, errors, velocity_errors, period)
                continue
            for interface, index in zip(interfaces, self._joints, strict=True):
                interface.value = values[index] if values else 0.0

    def _write_pid(
        self,
        name: str,
        interfaces: Sequence[CommandInterface],
        state: TrajectoryPoint,
        errors: Sequence[float],
        velocity_errors: Sequence[float],
        period: float,
    ) -> None:
        for interface, index in zip(interfaces, self._joints, strict=True):
            pid = self._pids[index]
            velocity_error = velocity_errors[index] if velocity_errors else 0.0
            output = pid.update(errors[index], velocity_error, period)
            if state.velocities:
                output += pid.gains.ff_velocity_scale * state.velocities[index]
            if name == EFFORT and state.effort:
                output += state.effort[index]
            interface.value = output

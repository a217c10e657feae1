"""The actuators of an MJCF file: commands in, MuJoCo's controls out.

Their forces are the file's own; a command is what a joint is to do, in radians or metres, and is
turned into the control with which the actuator does that.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from teleopctl.mujoco_model import JointSpec
    from teleopctl.robot import JointActuator

_INTERFACES = ("position", "velocity", "effort")


class FileActuators:
    """Actuators of an MJCF file, by the joints that they move.

    Args:
        model: The ``mujoco.MjModel``.
        data: Its ``mujoco.MjData``.
        joints: The robot's movable joints.
    """

    # Any stands for MuJoCo's types, which have no static ones.
    def __init__(self, model: Any, data: Any, joints: Sequence[JointSpec]) -> None:
        self._m, self._d = model, data
        self._parts = {
            joint.name: [
                (
                    _INTERFACES.index(actuator.interface),
                    int(model.actuator(actuator.name).id),
                    actuator,
                )
                for actuator in joint.actuators
            ]
            for joint in joints
            if joint.actuators
        }
        self._limits = {joint.name: joint.limits.mechanical for joint in joints}

    def __len__(self) -> int:
        return len(self._parts)

    def __contains__(self, joint: object) -> bool:
        return joint in self._parts

    def hold_here(self) -> None:
        """Set the actuators that can hold a joint to its present position."""
        for joint, parts in self._parts.items():
            position = float(self._d.joint(joint).qpos[0])
            for interface, number, actuator in parts:
                first = int(self._m.actuator_actadr[number])
                if interface == 0:
                    self._d.ctrl[number] = _control(actuator, position)
                if first >= 0 and interface < 2:
                    # What filters a position or adds up speeds remembers where it is.
                    self._d.act[first] = _control(actuator, position)

    def apply(
        self,
        names: Sequence[str],
        position: Sequence[float],
        velocity: Sequence[float],
        effort: Sequence[float],
    ) -> None:
        """Apply commands for the control period that begins now; see `Drives.apply`."""
        given = [
            values if len(values) == len(names) else () for values in (position, velocity, effort)
        ]
        columns = {name: column for column, name in enumerate(names) if name in self._parts}
        for joint, parts in self._parts.items():
            column = columns.get(joint)
            limits = self._limits[joint]
            for interface, number, actuator in parts:
                values = given[interface]
                value = float(values[column]) if column is not None and values else float("nan")
                if isfinite(value):
                    if interface == 0:
                        value = min(max(value, limits.lower), limits.upper)
                    self._d.ctrl[number] = _control(actuator, value)
                elif interface:
                    self._d.ctrl[number] = _control(actuator, 0.0)

    def hold(self) -> None:
        """Stop actuators without commands; position actuators keep their targets."""
        self.apply((), (), (), ())


def _control(actuator: JointActuator, command: float) -> float:
    return actuator.scale * command + actuator.offset

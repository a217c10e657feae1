"""How a simulation begins: where everything is, and what the file's actuators are told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

Values = Mapping[str, npt.NDArray[np.float64]]


@dataclass(frozen=True)
class MjcfStart:
    """Initial state of an MJCF file, by names of joints and actuators.

    Attributes:
        positions: Of joints, as MuJoCo's ``qpos``.
        velocities: Of joints, as MuJoCo's ``qvel``.
        controls: Of actuators.
        activations: Of actuators.
    """

    positions: Values = field(default_factory=dict)
    velocities: Values = field(default_factory=dict)
    controls: Mapping[str, float] = field(default_factory=dict)
    activations: Values = field(default_factory=dict)

    # Any stands for MuJoCo's types, which have no static ones.
    @classmethod
    def of(cls, model: Any, data: Any) -> MjcfStart:
        """Return the state of a simulation."""
        joints = [(model.joint(n).name, data.joint(n)) for n in range(model.njnt)]
        actuators = [model.actuator(n) for n in range(model.nu)]
        return cls(
            {name: np.array(joint.qpos) for name, joint in joints},
            {name: np.array(joint.qvel) for name, joint in joints},
            {actuator.name: float(data.ctrl[actuator.id]) for actuator in actuators},
            {
                actuator.name: np.array(data.act[_activations(actuator)])
                for actuator in actuators
                if actuator.actnum[0]
            },
        )

    def without(self, joint: str) -> MjcfStart:
        """Return the state without a joint."""
        return replace(
            self,
            positions={name: values for name, values in self.positions.items() if name != joint},
            velocities={name: values for name, values in self.velocities.items() if name != joint},
        )

    def apply(self, model: Any, data: Any) -> None:
        """Set a simulation to the state."""
        for name, values in self.positions.items():
            data.joint(name).qpos[:] = values
        for name, values in self.velocities.items():
            data.joint(name).qvel[:] = values
        for name, value in self.controls.items():
            data.actuator(name).ctrl[0] = value
        for name, values in self.activations.items():
            data.act[_activations(model.actuator(name))] = values


def _activations(actuator: Any) -> slice:
    first = int(actuator.actadr[0])
    return slice(first, first + int(actuator.actnum[0]))

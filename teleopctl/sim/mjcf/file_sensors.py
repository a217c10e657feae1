"""Sensors that MuJoCo reads as the robot's file has them: ``touch`` and ``rangefinder``."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError
from teleopctl.sim.sensors.base import Sensor


class _OfFile(Sensor):
    """One number of a sensor in an MJCF file, with the noise that the file says."""

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Find the sensor of the file."""
        kind = self.description.type
        self._sensor = self.description.texts.get(f"{kind}/sensor", "")
        if spec.sensor(self._sensor) is None:
            raise InvalidDescriptionError(f"it is one of MJCF files, with its name in <{kind}>")

    def _value(self, data: mujoco.MjData) -> float:
        return float(data.sensor(self._sensor).data[0])

    def _disturbed(self, value: float, data: mujoco.MjData) -> float:
        noise = self.noise(self.description.type)
        return float(noise.disturb(np.array([value]), float(data.time))[0])


class Touch(_OfFile):
    """The sum of the normal forces of contacts within the sensor's site, in N."""

    message_type = "std_msgs/msg/Float64"

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Read the force."""
        del model
        message.data = self._disturbed(self._value(data), data)


class Rangefinder(_OfFile):
    """The distance along one ray to any shape, but for those of the body that it starts on.

    What meets nothing, or nothing until the cutoff, is infinite (REP 117).
    """

    message_type = "sensor_msgs/msg/Range"

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Read the distance; MuJoCo has -1 where the ray meets nothing."""
        cutoff = float(model.sensor(self._sensor).cutoff[0])
        message.radiation_type = 1  # infrared
        message.max_range = cutoff or math.inf
        value = self._value(data)
        met = value >= 0.0 and (not cutoff or value < cutoff)
        message.range = max(0.0, self._disturbed(value, data)) if met else math.inf

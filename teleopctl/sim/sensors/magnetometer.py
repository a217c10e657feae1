"""Sensor type ``magnetometer``: magnetic field of the earth."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from teleopctl.sim.sensors.base import Sensor

# SDF's default field of a world, in tesla along x east, y north, z up.
_FIELD = np.array([5.5645e-6, 22.8758e-6, -42.3884e-6])
# MuJoCo's default field, without a unit.
_UNSET = mujoco.MjOption().magnetic.copy()


class Magnetometer(Sensor):
    """Magnetometer: the world's magnetic field in the sensor's axes, in tesla."""

    message_type = "sensor_msgs/msg/MagneticField"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the magnetometer's site to a spec."""
        self.add_site(spec)

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a MagneticField message with the field in the sensor's axes."""
        field_setting = model.opt.magnetic
        in_world = _FIELD if np.array_equal(field_setting, _UNSET) else field_setting
        field = data.site(self.name).xmat.reshape(3, 3).T @ in_world
        for axis, name in enumerate("xyz"):
            noise = self.noise(f"magnetometer/{name}")
            measured = noise.add_noise(field[axis : axis + 1], float(data.time))
            setattr(message.magnetic_field, name, float(measured[0]))
            message.magnetic_field_covariance[4 * axis] = noise.variance

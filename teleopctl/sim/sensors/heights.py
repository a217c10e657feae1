"""Sensor types ``altimeter`` and ``air_pressure``."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from teleopctl.sim.sensors.base import Sensor

# The international standard atmosphere (ISO 2533) at sea level, and its lapse rate.
_PRESSURE_PA = 101_325.0
_TEMPERATURE_K = 288.15
_LAPSE_K_PER_M = 0.0065
_EXPONENT = 5.25588


class Altimeter(Sensor):
    """Altimeter: height above the world's origin (m) and its rate (m/s).

    The reference of the message is that origin, not the robot's starting position.
    """

    message_type = "ros_gz_interfaces/msg/Altimeter"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the altimeter's site to a spec."""
        self.add_site(spec)

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill an Altimeter message with height and vertical velocity."""
        height = np.array(data.site(self.name).xpos[2:])
        rate = self.velocity(model, data)[2:]
        time_s = float(data.time)
        height = self.noise("altimeter/vertical_position").add_noise(height, time_s)
        rate = self.noise("altimeter/vertical_velocity").add_noise(rate, time_s)
        message.vertical_position, message.vertical_velocity = float(height[0]), float(rate[0])


class AirPressure(Sensor):
    """Air pressure sensor: pressure (Pa) by the standard atmosphere."""

    message_type = "sensor_msgs/msg/FluidPressure"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the pressure sensor's site to a spec."""
        self.add_site(spec)

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a FluidPressure message with the air pressure at the site's height."""
        del model
        reference = self.description.texts.get("air_pressure/reference_altitude")
        altitude = float(reference) if reference else self.origin.altitude_m
        height = altitude + float(data.site(self.name).xpos[2])
        # The formula ends at 44 km, where the pressure is zero.
        cooling = max(0.0, 1.0 - _LAPSE_K_PER_M * height / _TEMPERATURE_K)
        exact = np.array([_PRESSURE_PA * cooling**_EXPONENT])
        noise = self.noise("air_pressure/pressure")
        message.fluid_pressure = float(noise.add_noise(exact, float(data.time))[0])
        message.variance = noise.variance

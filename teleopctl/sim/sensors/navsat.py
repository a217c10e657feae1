"""Sensor types ``navsat`` and ``gps``: satellite navigation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from teleopctl.sim.sensors.base import Sensor

_FIX, _GPS, _DIAGONAL, _UNKNOWN = 0, 1, 2, 0


class NavSat(Sensor):
    """Satellite navigation: latitude, longitude (deg) and altitude (m, WGS 84).

    The world's x axis points east, y north and z up from its origin on the earth.
    """

    message_type = "sensor_msgs/msg/NavSatFix"

    def companions(self) -> Sequence[Sensor]:
        """Return the velocity sensor, if a Gazebo classic plug-in publishes the velocity too."""
        return (NavSatVelocity(self.description),) if self.names.has_plugin else ()

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the receiver's site to a spec."""
        self.add_site(spec)

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a NavSatFix message with the site's position on the earth."""
        del model
        kind, time_s = self.description.type, float(data.time)
        horizontal = self.noise(f"{kind}/position_sensing/horizontal")
        vertical = self.noise(f"{kind}/position_sensing/vertical")
        place = np.array(data.site(self.name).xpos)
        east, north = horizontal.add_noise(place[:2], time_s)
        (up,) = vertical.add_noise(place[2:], time_s)
        point = self.origin.offset(float(east), float(north), float(up))
        message.status.status, message.status.service = _FIX, _GPS
        message.latitude, message.longitude, message.altitude = point
        variances = (horizontal.variance, horizontal.variance, vertical.variance)
        for axis, variance in enumerate(variances):
            message.position_covariance[4 * axis] = variance
        message.position_covariance_type = _DIAGONAL if any(variances) else _UNKNOWN


class NavSatVelocity(Sensor):
    """Velocity of a satellite navigation receiver to the east, north and up, in m/s."""

    message_type = "geometry_msgs/msg/Vector3Stamped"
    plugin_topic = "~/vel"

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a Vector3Stamped message with the site's velocity."""
        kind, time_s = self.description.type, float(data.time)
        velocity = self.velocity(model, data)
        east, north = self.noise(f"{kind}/velocity_sensing/horizontal").add_noise(
            velocity[:2], time_s
        )
        (up,) = self.noise(f"{kind}/velocity_sensing/vertical").add_noise(velocity[2:], time_s)
        message.vector.x, message.vector.y, message.vector.z = float(east), float(north), float(up)

"""``imu``: an inertial measurement unit without noise."""

from __future__ import annotations

from typing import Any

import mujoco

from teleopctl.sim.sensors.base import Sensor


class Imu(Sensor):
    """Turn rate, acceleration and orientation of a link, by REP 145.

    Turn rate (rad/s) and acceleration (m/s²) are those of the sensor, along its own axes; the
    acceleration is what an accelerometer measures, 9.81 upwards at rest. The orientation is that
    of the sensor in the world, which is x east, y north, z up (REP 103). The covariances are zero,
    which says that they are not known.
    """

    message_type = "sensor_msgs/msg/Imu"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add a gyroscope, an accelerometer and a compass at the sensor's place."""
        site = self.add_site(spec)
        for suffix, kind in (
            ("gyro", mujoco.mjtSensor.mjSENS_GYRO),
            ("accelerometer", mujoco.mjtSensor.mjSENS_ACCELEROMETER),
            ("orientation", mujoco.mjtSensor.mjSENS_FRAMEQUAT),
        ):
            spec.add_sensor(
                name=f"{self.name}/{suffix}",
                type=kind,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=site.name,
            )

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Copy what the three measure."""
        del model
        q, rate, acceleration = (
            message.orientation,
            message.angular_velocity,
            message.linear_acceleration,
        )
        q.w, q.x, q.y, q.z = data.sensor(f"{self.name}/orientation").data
        rate.x, rate.y, rate.z = data.sensor(f"{self.name}/gyro").data
        acceleration.x, acceleration.y, acceleration.z = data.sensor(
            f"{self.name}/accelerometer"
        ).data

"""Sensor type ``imu``: inertial measurement unit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError
from teleopctl.sim.sensors.base import Sensor

if TYPE_CHECKING:
    from teleopctl.robot import SensorTag as Description

_REFERENCE = "imu/orientation_reference_frame"
# Rotations in the world, which is ENU, of the frames that an orientation may refer to: roll, pitch
# and yaw in radians.
_FRAMES = {
    "ENU": (0.0, 0.0, 0.0),
    "NED": (math.pi, 0.0, math.pi / 2.0),
    "NWU": (0.0, 0.0, math.pi / 2.0),
}
# Parts of the message, and the sensors of MuJoCo that measure them.
_VECTORS = (("angular_velocity", "gyro"), ("linear_acceleration", "accelerometer"))


class Imu(Sensor):
    """IMU: angular velocity, linear acceleration and orientation of a link, by REP 145.

    Angular velocity (rad/s) and acceleration (m/s²) are those of the sensor, along its own axes;
    the acceleration is that of an accelerometer, 9.81 upwards at rest. The orientation is that
    of the sensor in the world, which is x east, y north, z up (REP 103), unless the tag
    ``<orientation_reference_frame>`` selects another frame. The covariances are those of
    ``<noise>``; without noise they are zero, which means unknown.

    Args:
        description: The ``<sensor>`` tag.
    """

    message_type = "sensor_msgs/msg/Imu"

    def __init__(self, description: Description) -> None:
        super().__init__(description)
        self._world_in_reference = np.zeros(4)
        mujoco.mju_euler2Quat(self._world_in_reference, np.array(self._reference()), "XYZ")
        mujoco.mju_negQuat(self._world_in_reference, self._world_in_reference.copy())

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add MuJoCo's gyroscope, accelerometer and orientation sensor at the IMU's site."""
        self.measure_at(
            spec,
            self.add_site(spec),
            gyro=mujoco.mjtSensor.mjSENS_GYRO,
            accelerometer=mujoco.mjtSensor.mjSENS_ACCELEROMETER,
            orientation=mujoco.mjtSensor.mjSENS_FRAMEQUAT,
        )

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill an Imu message with noisy angular velocity and acceleration, and orientation."""
        del model
        q = message.orientation
        if self._has_orientation:
            turn = np.zeros(4)
            in_world = data.sensor(f"{self.name}/orientation").data
            mujoco.mju_mulQuat(turn, self._world_in_reference, in_world)
            q.w, q.x, q.y, q.z = map(float, turn)
        else:
            # REP 145: a first element of -1 means that there is no orientation.
            message.orientation_covariance[0] = -1.0
        for part, suffix in _VECTORS:
            vector = getattr(message, part)
            covariance = getattr(message, f"{part}_covariance")
            exact = np.array(data.sensor(f"{self.name}/{suffix}").data)
            for axis, name in enumerate("xyz"):
                noise = self.noise(f"imu/{part}/{name}")
                measured = noise.add_noise(exact[axis : axis + 1], float(data.time))
                setattr(vector, name, float(measured[0]))
                covariance[4 * axis] = noise.variance

    def _reference(self) -> tuple[float, ...]:
        """Return roll, pitch and yaw of the frame that the orientation refers to."""
        localization = self.description.texts.get(f"{_REFERENCE}/localization", "")
        if localization != "CUSTOM":
            return _FRAMES.get(localization, _FRAMES["ENU"])
        text = self.description.texts.get(f"{_REFERENCE}/custom_rpy", "0 0 0")
        try:
            roll, pitch, yaw = map(float, text.split())
        except ValueError as error:
            raise InvalidDescriptionError(
                f"<custom_rpy> should be 3 numbers, got '{text}'"
            ) from error
        return roll, pitch, yaw

    @property
    def _has_orientation(self) -> bool:
        enabled = self.description.texts.get("imu/enable_orientation", "true")
        return enabled.lower() in ("true", "1")

"""Pose sensor of a link, for ``<ros2_control>`` state interfaces."""

from __future__ import annotations

from typing import Any

import mujoco

from teleopctl.sim.sensors.base import Sensor


class PoseSensor(Sensor):
    """Pose sensor: position (m) and orientation of a link in the world, without noise.

    The sensor is for state interfaces alone: see `teleopctl.sim.sensors.interfaces`.
    """

    message_type = "geometry_msgs/msg/PoseStamped"

    @property
    def frame_id(self) -> str:
        """Frame of the measurement, ``world``."""
        return "world"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add MuJoCo's position and orientation sensors at the link's frame to a spec."""
        self.measure_at(
            spec,
            self.add_site(spec),
            position=mujoco.mjtSensor.mjSENS_FRAMEPOS,
            orientation=mujoco.mjtSensor.mjSENS_FRAMEQUAT,
        )

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a PoseStamped message with the link's pose in the world."""
        del model
        position, turn = message.pose.position, message.pose.orientation
        position.x, position.y, position.z = data.sensor(f"{self.name}/position").data
        turn.w, turn.x, turn.y, turn.z = data.sensor(f"{self.name}/orientation").data

"""Where a link is in the world, as a motion capture system would measure it."""

from __future__ import annotations

from typing import Any

import mujoco

from teleopctl.sim.sensors.base import Sensor


class PoseSensor(Sensor):
    """Pose sensor: position (m) and orientation of a link in the world, without noise.

    It measures for state interfaces alone: see `teleopctl.sim.sensors.interfaces`.
    """

    message_type = "geometry_msgs/msg/PoseStamped"

    @property
    def frame_id(self) -> str:
        """Frame of the measurement."""
        return "world"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add MuJoCo's position and orientation sensors at the link's frame."""
        self.measure_at(
            spec,
            self.add_site(spec),
            position=mujoco.mjtSensor.mjSENS_FRAMEPOS,
            orientation=mujoco.mjtSensor.mjSENS_FRAMEQUAT,
        )

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill the message with the pose."""
        del model
        position, turn = message.pose.position, message.pose.orientation
        position.x, position.y, position.z = data.sensor(f"{self.name}/position").data
        turn.w, turn.x, turn.y, turn.z = data.sensor(f"{self.name}/orientation").data

"""Sensor type ``force_torque``: wrench between a link and its parent."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from teleopctl.sim.sensors.base import Sensor


class ForceTorque(Sensor):
    """Force-torque sensor at a joint: force (N) and torque (N m).

    By default the wrench is that of the child on its parent, along the child's axes, as in Gazebo:
    a link of mass m that hangs at rest gives ``m g`` downwards. The torque is about the origin of
    the child link, which is also that of the joint.
    """

    plugin_topic = "wrench"
    message_type = "geometry_msgs/msg/WrenchStamped"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add MuJoCo's force and torque sensors to a spec, at the joint's origin or the site."""
        site, frame = self.add_site(spec), self.description.force_torque.frame
        if frame != "site":
            site.pos = np.zeros(3)
        if frame not in ("site", "sensor"):
            site.quat = np.array([1.0, 0.0, 0.0, 0.0])
        self.measure_at(
            spec,
            site,
            force=mujoco.mjtSensor.mjSENS_FORCE,
            torque=mujoco.mjtSensor.mjSENS_TORQUE,
        )

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a WrenchStamped message with the joint's wrench, in the frame and sign described."""
        settings = self.description.force_torque
        # MuJoCo measures the wrench of the parent on the child.
        sign = 1.0 if settings.measure_direction == "parent_to_child" else -1.0
        for suffix in ("force", "torque"):
            vector = sign * np.array(data.sensor(f"{self.name}/{suffix}").data)
            if settings.frame == "parent":
                parent = model.body_parentid[model.site(self.name).bodyid[0]]
                to_world = data.site(self.name).xmat.reshape(3, 3)
                vector = data.xmat[parent].reshape(3, 3).T @ to_world @ vector
            part = getattr(message.wrench, suffix)
            for axis, name in enumerate("xyz"):
                noise = self.noise(f"force_torque/{suffix}/{name}")
                measured = noise.add_noise(vector[axis : axis + 1], float(data.time))
                setattr(part, name, float(measured[0]))

"""Base class of simulated sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import RosNames
from teleopctl.sim.sensors.geodesy import GeoPoint
from teleopctl.sim.sensors.noise import NoiseSource

if TYPE_CHECKING:
    from teleopctl.robot import SensorTag as Description

# Rate (Hz) of the steps of a drifting bias for sensors without an ``update_rate``.
_USUAL_RATE_HZ = 100.0


class Sensor:
    """Base class of simulated sensors; a subclass simulates one ``<sensor type="…">`` of Gazebo.

    The simulator's node publishes the sensor's messages, with stamp and frame, at the sensor's
    ``update_rate`` in simulated time and only while there are subscribers. If a sensor raises an
    exception, the simulation continues without it.

    Args:
        description: The ``<sensor>`` tag.

    Attributes:
        message_type: ROS type of the published messages.
        description: The ``<sensor>`` tag.
        name: Name for MuJoCo, unique in the robot.
        names: Topic names, remappings and plug-in settings of the description.
        seed: Seed of the sensor's noise.
        origin: Position of the world's origin on the earth.
    """

    message_type: str
    seed = 0
    origin = GeoPoint()

    def __init__(self, description: Description) -> None:
        self.description = description
        self.name = f"{description.link}/{description.name}"
        self.names = RosNames(description)
        self._noises: dict[str, NoiseSource] = {}

    def companions(self) -> Sequence[Sensor]:
        """Return further sensors for the same measurement in other messages; none by default.

        Companions are added to the model too, after this sensor.
        """
        return ()

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the sensor's sites and MuJoCo sensors to a spec, before the model is compiled.

        A sensor must not change the motion: no mass, no contacts, no forces.

        Args:
            spec: The robot's ``mujoco.MjSpec``; its bodies have the names of the links.

        Raises:
            TeleopctlError: The description has unsupported settings.
        """

    # Any: the message is of the class that `message_type` names.
    def headers(self, message: Any) -> Sequence[Any]:
        """Return the headers of a new message, whose frame and stamp the publisher sets."""
        header = getattr(message, "header", None)
        return () if header is None else (header,)

    # Any: likewise.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Measure from MuJoCo's model and data, and fill the message.

        Args:
            model: The ``mujoco.MjModel``.
            data: The ``mujoco.MjData`` at the time of the measurement; not to be changed.
            message: Message to fill, the same one each time, with its header already set.
        """
        raise NotImplementedError

    # Whether the measurement is a noiseless part of the state, to be published while paused too.
    is_state: ClassVar[bool] = False

    # Default topic of Gazebo's plug-in for this type of sensor.
    plugin_topic: ClassVar[str] = "~/out"

    @property
    def topic(self) -> str:
        """Name of the topic, by the rules of Gazebo's plug-ins.

        The target of the plug-in's remapping; else ``<topic>``, else the plug-in's own topic, else
        the sensor's name.
        """
        names = self.names
        topic = names.remapped(self.plugin_topic) or names.topic
        topic = topic or names.setting("topicName", "topic_name")
        if not topic and names.has_plugin:
            topic = names.of_plugin(self.plugin_topic)
        return topic or self.description.name

    @property
    def frame_id(self) -> str:
        """Frame of the measurement: that of the description, else the sensor's link."""
        named = self.names.setting("frame_name", "frameName", "frame_id")
        return self.description.frame or named or self.description.link

    def noise(self, *parts: str) -> NoiseSource:
        """Return the noise of the first of the given ``<sensor>`` elements that has ``<noise>``.

        Args:
            parts: Paths of the elements that may contain ``<noise>``.
        """
        source = self._noises.get(parts[0])
        if source is None:
            found = self.description.noise
            part = next((part for part in parts if part in found), parts[0])
            period_s = 1.0 / (self.description.update_rate or _USUAL_RATE_HZ)
            source = NoiseSource(found.get(part), self.seed, f"{self.name}/{part}", period_s)
            self._noises[parts[0]] = source
        return source

    def velocity(
        self, model: mujoco.MjModel, data: mujoco.MjData
    ) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Return the linear velocity of the sensor's site in the world, in m/s, (3,)."""
        twist = np.zeros(6)
        site = model.site(self.name).id
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, twist, 0)
        return twist[3:]

    def add_site(self, spec: mujoco.MjSpec) -> mujoco.MjsSite:
        """Add a site at the sensor's pose to its link in a spec, and return the site.

        Raises:
            InvalidDescriptionError: The robot does not have the link of the sensor.
        """
        body = spec.body(self.description.link)
        if body is None:
            raise InvalidDescriptionError(f"the robot has no link '{self.description.link}'")
        pose = self.description.pose
        rotation = np.zeros(4)
        mujoco.mju_euler2Quat(rotation, np.array(pose.rpy), "XYZ")
        return body.add_site(name=self.name, pos=list(pose.xyz), quat=rotation)

    def measure_at(
        self, spec: mujoco.MjSpec, site: mujoco.MjsSite, **kinds: mujoco.mjtSensor
    ) -> None:
        """Add MuJoCo sensors at a site to a spec.

        Args:
            spec: The ``mujoco.MjSpec`` to edit.
            site: Site of the sensors.
            kinds: MuJoCo's types of the sensors, by the suffix of their names: ``gyro`` for
                ``NAME/gyro``.
        """
        for suffix, kind in kinds.items():
            spec.add_sensor(
                name=f"{self.name}/{suffix}",
                type=kind,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=site.name,
            )

"""The class that every simulated sensor derives from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError

if TYPE_CHECKING:
    from teleopctl.robot import Sensor as Description


class Sensor:
    """A ``<gazebo><sensor type="…">`` of a robot description, in the simulator.

    The simulator publishes its messages from its own node, with stamp and frame, at the sensor's
    ``update_rate`` in simulated time and only while somebody subscribes. It may fail as it likes:
    the simulation goes on without it.


    Args:
        description: What the ``<sensor>`` says.

    Attributes:
        message_type: The ROS type of what it publishes.
        description: What the ``<sensor>`` says.
        name: A name for MuJoCo, unique in the robot.
    """

    message_type: ClassVar[str]

    def __init__(self, description: Description) -> None:
        self.description = description
        self.name = f"{description.link}/{description.name}"

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add what it measures with, such as MuJoCo's own sensors, before the model is compiled.

        It must not change the motion: no mass, no contacts, no forces.

        Args:
            spec: The robot's ``mujoco.MjSpec``; its bodies are named as the links.

        Raises:
            TeleopctlError: The description asks for what cannot be had.
        """

    # Any: the message is of the class that `message_type` names.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Measure.

        Args:
            model: The ``mujoco.MjModel``.
            data: The ``mujoco.MjData`` at the time of the measurement; not to be changed.
            message: What to fill; it is the same one each time, its header is filled already.
        """
        raise NotImplementedError

    @property
    def topic(self) -> str:
        """``<topic>``, or what a plug-in of Gazebo remaps ``~/out`` to, or the sensor's name."""
        remappings = (
            text.partition(":=")
            for plugin in self.description.plugins
            for text in plugin.parameters.get("ros/remapping", ())
        )
        remapped = {source: target for source, _, target in remappings}
        return self.description.topic or remapped.get("~/out") or self.description.name

    @property
    def frame_id(self) -> str:
        """The frame of the measurement: what the description says, or the link."""
        named = (plugin.parameter("frame_name") for plugin in self.description.plugins)
        return self.description.frame or next(filter(None, named), self.description.link)

    def add_site(self, spec: mujoco.MjSpec) -> mujoco.MjsSite:
        """Add a site with the sensor's pose to its link and return it.

        Raises:
            InvalidDescriptionError: The robot has no such link.
        """
        body = spec.body(self.description.link)
        if body is None:
            raise InvalidDescriptionError(f"the robot has no link '{self.description.link}'")
        pose = self.description.pose
        rotation = np.zeros(4)
        mujoco.mju_euler2Quat(rotation, np.array(pose.rpy), "XYZ")
        return body.add_site(name=self.name, pos=list(pose.xyz), quat=rotation)

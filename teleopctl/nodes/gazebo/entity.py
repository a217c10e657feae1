"""What is to be spawned, as ``create`` and ``spawn_entity.py`` hand it to the simulator."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.node import Parameter
from teleopctl.robot import RobotDescription, model_kind, read_model

# Parameters of the simulator: what is to be spawned, and what to know of it besides.
DESCRIPTION = "robot_description"
POSE = "robot_pose"
_NAME, _FILE, _TOPIC, _RENAMES = "entity_name", "entity_file", "entity_topic", "entity_renames"
NOWHERE = (0.0,) * 6


class GazeboEntity(NamedTuple):
    """An entity to spawn or to delete.

    Attributes:
        text: URDF, or SDF; empty to take it out.
        name: What it is to be called; empty for its own name.
        file: Where the text is from; empty for no file.
        topic: The topic on which the text was heard, or empty.
        renames: Whether it may be called otherwise where there is one of that name.
        pose: Where it is to be: x, y, z, roll, pitch, yaw.
    """

    text: str = ""
    name: str = ""
    file: str = ""
    topic: str = ""
    renames: bool = False
    pose: tuple[float, ...] = NOWHERE

    # Any: a parameter's value is of one of many types.
    @classmethod
    def of_parameters(cls, values: Mapping[str, Any]) -> GazeboEntity:
        """Return the entity that node parameters describe."""
        return cls(
            str(values[DESCRIPTION] or ""),
            str(values.get(_NAME) or ""),
            str(values.get(_FILE) or ""),
            str(values.get(_TOPIC) or ""),
            bool(values.get(_RENAMES)),
            tuple(values.get(POSE) or NOWHERE),
        )

    def as_parameters(self) -> list[Parameter]:
        """Return the entity as node parameters."""
        return [
            Parameter(DESCRIPTION, value=self.text),
            Parameter(_NAME, value=self.name),
            Parameter(_FILE, value=self.file),
            Parameter(_TOPIC, value=self.topic),
            Parameter(_RENAMES, value=self.renames),
            Parameter(POSE, value=list(self.pose)),
        ]

    def urdf(self, folder: Path) -> str:
        """Return the entity's description as URDF.

        Args:
            folder: Where files may be written.

        Raises:
            InvalidDescriptionError: It is SDF that cannot be read.
        """
        if self.file and model_kind(self.file) == "sdf":
            return read_model(self.file).text
        if "<sdf" not in self.text:
            return self.text
        file = Path(tempfile.mkdtemp(dir=folder)) / "model.sdf"
        file.write_text(self.text, "utf-8")
        return read_model(file).text if model_kind(file) == "sdf" else self.text

    def claim(self, description: RobotDescription) -> tuple[bool, bool]:
        """Return a rank for being the robot: whether plug-ins are to run, and a topic describes it.

        Returns:
            Whether it asks for something to be run: controllers, plug-ins, sensors; and whether
            ROS has its description on a topic.
        """
        gazebo = description.gazebo
        asks = bool(description.ros2_control or gazebo.plugins or gazebo.sensors)
        return asks, bool(self.topic)

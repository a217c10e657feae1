"""A plug-in of Gazebo: which one it is, its settings, and the ROS names that it uses."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import Vector3, boolean, to_number

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription
    from teleopctl.robot.sensors.plugin_tag import PluginTag

_NO_LETTERS = re.compile(r"\W+")
_CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
# What stands around a plug-in's own name: `libgazebo_ros_X.so`, `gz-sim8-X-system`, and Gazebo's
# while it was named Ignition.
_AROUND = re.compile(
    r"(?:lib)?(?:(?P<classic>gazebo_ros)_|(?:gz-sim|ignition-gazebo)\d*-)(?P<name>.+?)(?:\.so)?"
)


def words(text: str) -> frozenset[str]:
    """Return the words of a text."""
    return frozenset(text.split())


def kind_of(filename: str) -> str:
    """Return a plug-in's name without the spelling of a Gazebo release.

    Args:
        filename: As the description has it.

    Returns:
        ``gazebo_ros_diff_drive``, ``gz-sim-diff-drive-system`` and so on; the file's name for
        what is not Gazebo's own.
    """
    match = _AROUND.fullmatch(filename.rpartition("/")[2])
    if match is None:
        return filename
    return f"{'gazebo_ros_' if match['classic'] else 'gz-sim-'}{match['name']}"


class PluginReader:
    """Reads the tags of one plug-in.

    Args:
        plugin: The plug-in.
        description: The robot.

    Attributes:
        name: The plug-in's, as a node may be named.
        robot: The robot's name.
        root: Its root link.
    """

    def __init__(self, plugin: PluginTag, description: RobotDescription) -> None:
        self._plugin = plugin
        self._description = description
        self.robot = description.name
        self.root = description.root
        self.name = _node_name(plugin.name)
        self._namespace = plugin.parameter("ros/namespace").strip("/")

    def text(self, *tags: str, default: str = "") -> str:
        """Return the text of the first of these tags that exists."""
        return next((text for tag in tags if (text := self._plugin.parameter(tag))), default)

    def number(self, *tags: str, default: float = math.nan) -> float:
        """Return the number in the first of these tags that exists."""
        values = self.numbers(*tags)
        return values[0] if values else default

    def numbers(self, *tags: str) -> list[float]:
        """Return the numbers in these tags.

        Raises:
            InvalidDescriptionError: One of them is none.
        """
        values = []
        for tag in tags:
            for text in self._plugin.parameters.get(tag, ()):
                value = to_number(text)
                if value is None:
                    raise InvalidDescriptionError(f"<{tag}> should be a number, got '{text}'")
                values.append(value)
        return values

    def flag(self, *tags: str, default: bool) -> bool:
        """Return the truth value in the first of these tags that exists."""
        text = self.text(*tags)
        if not text:
            return default
        return text == "1" if text in ("0", "1") else boolean(text, f"<{tags[0]}>")

    def joints(self, *tags: str) -> list[str]:
        """Return the joints named in these tags.

        Raises:
            InvalidDescriptionError: The robot has no such joint.
        """
        names = [text for tag in tags for text in self._plugin.parameters.get(tag, ())]
        for name in names:
            if name not in self._description.joints:
                raise InvalidDescriptionError(f"there is no joint '{name}'")
        return names

    def free_joints(self) -> list[str]:
        """Return the revolute and prismatic joints that mimic no other joint."""
        return [
            name
            for name, joint in self._description.joints.items()
            if joint.type in ("revolute", "prismatic") and joint.mimic is None
        ]

    def link(self, *tags: str) -> str:
        """Return the link named in the first of these tags.

        Raises:
            InvalidDescriptionError: The robot has no such link.
        """
        name = self.text(*tags)
        if name not in self._description.links:
            raise InvalidDescriptionError(
                f"there is no link '{name}'" if name else f"it has no <{tags[0]}>"
            )
        return name

    def vector(self, *tags: str) -> Vector3:
        """Return the three numbers in the first of these tags that exists, else zeros.

        Raises:
            InvalidDescriptionError: It has something else.
        """
        text = self.text(*tags, default="0 0 0")
        numbers = [value for word in text.split() if (value := to_number(word)) is not None]
        if len(numbers) != 3 or len(text.split()) != 3:
            raise InvalidDescriptionError(f"<{tags[0]}> should be three numbers, got '{text}'")
        return numbers[0], numbers[1], numbers[2]

    def topic(self, name: str) -> str:
        """Return the full ROS name of a Gazebo Classic plug-in's topic.

        Args:
            name: As the plug-in calls it.
        """
        for rule in self._plugin.parameters.get("ros/remapping", ()):
            source, _, target = rule.partition(":=")
            if self._whole(source.strip()) == self._whole(name):
                return self._whole(target.strip())
        return self._whole(name)

    def _whole(self, name: str) -> str:
        if name.startswith("/"):
            return name
        if name.startswith("~/"):
            name = f"{self.name}/{name[2:]}"
        return f"/{self._namespace}/{name}" if self._namespace else f"/{name}"

    def gz_topic(self, tag: str, own: str) -> str:
        """Return a Gazebo topic: that of a tag, else the default below the model's name.

        Args:
            tag: The tag.
            own: Its last part by default.
        """
        return f"/{self.text(tag, default=f'model/{self.robot}/{own}').strip('/')}"


def _node_name(name: str) -> str:
    """A plug-in's name as one that a node may have: ``gz::sim::systems::DiffDrive`` too."""
    last = name.rpartition("::")[2]
    if "::" in name:
        last = _CAMEL.sub("_", last).lower()
    return _NO_LETTERS.sub("_", last).strip("_") or "plugin"

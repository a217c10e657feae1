"""The parameters of a Gazebo plug-in, and its equivalent here: a controller, odometry or topics."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import Vector3, boolean, to_number
from teleopctl.robot.urdf import Pose

if TYPE_CHECKING:
    from teleopctl.robot.description import RobotDescription
    from teleopctl.robot.sensor_tag import PluginTag


@dataclass(frozen=True)
class PluginController:
    """Controller that replaces a Gazebo plug-in: type, parameters, remappings and joints.

    Attributes:
        name: Name of the controller: the name of the plug-in.
        type: Type of the controller.
        parameters: Parameters of the controller's node.
        remappings: Remappings from the controller's names to the plug-in's.
        joints: Command interface of each joint that the controller moves.
        efforts: Effort limits of joints, N m or N, if the plug-in has them.
    """

    name: str
    type: str
    # Any: parameters have one of nine types.
    parameters: Mapping[str, Any]
    remappings: tuple[str, ...]
    joints: Mapping[str, str]
    efforts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class GroundTruth:
    """True odometry of a link, to be published by the simulator.

    Attributes:
        name: Name of the plug-in.
        link: Link that the odometry describes.
        frame_id: Frame of the pose; the name of a link if ``relative_to`` is set.
        child_frame_id: Frame of the link.
        topic: Topic of ``nav_msgs/msg/Odometry``; empty for none.
        tf_topic: Topic of ``tf2_msgs/msg/TFMessage``; empty for none.
        rate_hz: Publishing rate; 0 to publish in every control period.
        in_child_frame: Whether velocities are along the axes of the link, as in REP 105, instead of
            those of ``frame_id``.
        relative_to: Link of ``frame_id``; empty for the world.
        offset: Translation and rotation added to the pose.
        noise: Standard deviation of the velocities, m/s and rad/s.
        pose_variance: Diagonal of the pose's covariance.
        twist_variance: Diagonal of the twist's covariance.
    """

    name: str
    link: str
    frame_id: str
    child_frame_id: str
    topic: str = ""
    tf_topic: str = ""
    rate_hz: float = 0.0
    in_child_frame: bool = True
    relative_to: str = ""
    offset: Pose = field(default_factory=Pose)
    noise: float = 0.0
    pose_variance: tuple[float, ...] = (0.0,) * 6
    twist_variance: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class PluginEffect:
    """Equivalent of one Gazebo plug-in: a controller, odometry or topics.

    Attributes:
        says: End of a sentence with the topics: "listens to /cmd_vel".
        controller: Controller that replaces the plug-in, or None.
        truths: Odometry for the simulator to publish.
        planar_topics: Topics of velocities by which the simulator moves the base.
    """

    says: str
    controller: PluginController | None = None
    truths: tuple[GroundTruth, ...] = ()
    planar_topics: tuple[str, ...] = ()


_NO_LETTERS = re.compile(r"\W+")
_CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
# File names of plug-ins: `libgazebo_ros_X.so`, `gz-sim8-X-system`, and the same with the prefix
# `ignition-gazebo`, Gazebo's former name.
_AROUND = re.compile(
    r"(?:lib)?(?:(?P<classic>gazebo_ros)_|(?:gz-sim|ignition-gazebo)\d*-)(?P<name>.+?)(?:\.so)?"
)


def words(text: str) -> frozenset[str]:
    """Return the words of a text, separated by blanks, as a set."""
    return frozenset(text.split())


def plugin_kind(filename: str) -> str:
    """Return the name of a Gazebo plug-in's file in one spelling for all releases.

    Args:
        filename: File name in the description.

    Returns:
        ``gazebo_ros_diff_drive``, ``gz-sim-diff-drive-system`` and so on; the file name
        for other plug-ins.
    """
    match = _AROUND.fullmatch(filename.rpartition("/")[2])
    if match is None:
        return filename
    return f"{'gazebo_ros_' if match['classic'] else 'gz-sim-'}{match['name']}"


class PluginReader:
    """Reader of one Gazebo plug-in's parameters.

    Args:
        plugin: ``<plugin>`` tag.
        description: Description of the robot.

    Attributes:
        name: Name of the plug-in as a valid node name.
        robot: Name of the robot.
        root: Root link of the robot.
    """

    def __init__(self, plugin: PluginTag, description: RobotDescription) -> None:
        self._plugin = plugin
        self._description = description
        self.robot = description.name
        self.root = description.root
        self.name = _node_name(plugin.name)
        self._namespace = plugin.parameter("ros/namespace").strip("/")

    def text(self, *tags: str, default: str = "") -> str:
        """Return the plug-in's first text among the given tags, or a default."""
        return next((text for tag in tags if (text := self._plugin.parameter(tag))), default)

    def number(self, *tags: str, default: float = math.nan) -> float:
        """Return the plug-in's first number among the given tags, or a default."""
        values = self.numbers(*tags)
        return values[0] if values else default

    def numbers(self, *tags: str) -> list[float]:
        """Return the plug-in's numbers in all given tags; raise if a text is no number.

        Raises:
            InvalidDescriptionError: A value is not a number.
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
        """Return the plug-in's first truth value among the given tags, or a default."""
        text = self.text(*tags)
        if not text:
            return default
        return text == "1" if text in ("0", "1") else boolean(text, f"<{tags[0]}>")

    def joints(self, *tags: str) -> list[str]:
        """Return the joint names in all given tags of the plug-in; raise for an unknown joint.

        Raises:
            InvalidDescriptionError: The robot has no such joint.
        """
        names = [text for tag in tags for text in self._plugin.parameters.get(tag, ())]
        for name in names:
            if name not in self._description.joints:
                raise InvalidDescriptionError(f"there is no joint '{name}'")
        return names

    def free_joints(self) -> list[str]:
        """Return the names of the robot's revolute and prismatic joints without ``<mimic>``."""
        return [
            name
            for name, joint in self._description.joints.items()
            if joint.type in ("revolute", "prismatic") and joint.mimic is None
        ]

    def link(self, *tags: str) -> str:
        """Return the link name in the plug-in's first given tag; raise if missing or unknown.

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
        """Return three numbers of the plug-in's first given tag that exists, else zeros.

        Raises:
            InvalidDescriptionError: The tag does not have three numbers.
        """
        text = self.text(*tags, default="0 0 0")
        numbers = [value for word in text.split() if (value := to_number(word)) is not None]
        if len(numbers) != 3 or len(text.split()) != 3:
            raise InvalidDescriptionError(f"<{tags[0]}> should be three numbers, got '{text}'")
        return numbers[0], numbers[1], numbers[2]

    def topic(self, name: str) -> str:
        """Return the full name of a Gazebo Classic plug-in's topic, after its remappings.

        Args:
            name: Name of the topic in the plug-in.
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
        """Return the topic in a tag, or the default ``/model/ROBOT/OWN`` with ``own`` at the end.

        Args:
            tag: Tag with the topic.
            own: Last part of the default.
        """
        return f"/{self.text(tag, default=f'model/{self.robot}/{own}').strip('/')}"


def _node_name(name: str) -> str:
    """Return a plug-in's name, such as ``gz::sim::systems::DiffDrive``, as a valid node name."""
    last = name.rpartition("::")[2]
    if "::" in name:
        last = _CAMEL.sub("_", last).lower()
    return _NO_LETTERS.sub("_", last).strip("_") or "plugin"

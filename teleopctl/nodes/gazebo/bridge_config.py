"""What a bridge between Gazebo and ROS 2 is to pass on: command lines, and files of ros_gz_bridge.

A word of the command line is ``/topic@ros_type@gz_type``, with ``[`` in place of the second ``@``
for Gazebo to ROS alone and ``]`` for the other way. A file is a list of mappings, whose topics may
have one name in ROS and another in Gazebo.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

from teleopctl.base.text_file import read_text
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.robot import ros_topic

_WORD: Final = re.compile(r"([^@]+)@([^@\[\]]+)([@\[\]])([^@\[\]]+)")
_SERVICE: Final = re.compile(r"([^@]+)@([^@\[\]]+/srv/[^@\[\]]+)(@[^@]+@[^@]+)?")
# What Gazebo calls the topics of a sensor that has no `<topic>`, and what the simulator here does.
_OF_SENSOR: Final = re.compile(r"/world/[^/]+/model/.+/link/[^/]+/sensor/(?P<sensor>[^/]+)/(.+)")
_ALONE: Final = frozenset(
    ["air_pressure", "altimeter", "contact", "forcetorque", "imu", "magnetometer", "navsat", "scan"]
)
_BELOW: Final = {
    "scan/points": ("{}/points",),
    "image": ("{}/image", "{}/image_raw", "image_raw"),
    "camera_info": ("{}/camera_info", "camera_info"),
}
_DIRECTIONS: Final = {"@": "BIDIRECTIONAL", "[": "GZ_TO_ROS", "]": "ROS_TO_GZ"}


class Bridge(NamedTuple):
    """A bridged topic.

    Attributes:
        ros_topic: Its name in ROS, before remapping.
        gz_topic: Its name in Gazebo.
        ros_type: Its type in ROS.
        direction: ``GZ_TO_ROS``, ``ROS_TO_GZ`` or ``BIDIRECTIONAL``.
    """

    ros_topic: str
    gz_topic: str
    ros_type: str
    direction: str = "BIDIRECTIONAL"


def simulated_topics(gz_topic: str) -> tuple[str, ...]:
    """Return the possible names of a Gazebo topic in teleopctl's simulator.

    The only camera of a robot has another name than one of several.
    """
    found = _OF_SENSOR.fullmatch(gz_topic)
    if found is None:
        return (gz_topic,)
    sensor, what = found["sensor"], found[2]
    names = ("{}",) if what in _ALONE else _BELOW.get(what, (f"{{}}/{what}",))
    return tuple(f"/{ros_topic(name.format(sensor))}" for name in names)


def read_words(words: Sequence[str]) -> tuple[list[Bridge], list[str]]:
    """Parse a bridge's command line.

    Returns:
        The topics, and the names of services.

    Raises:
        UsageError: A word names neither.
    """
    bridges: list[Bridge] = []
    services: list[str] = []
    for word in words:
        if service := _SERVICE.fullmatch(word):
            services.append(service[1])
        elif topic := _WORD.fullmatch(word):
            bridges.append(Bridge(topic[1], topic[1], topic[2], _DIRECTIONS[topic[3]]))
        else:
            raise UsageError(
                f"'{word}' is no topic to bridge",
                hint="Usage: parameter_bridge TOPIC@ROS_TYPE@GZ_TYPE …, with [ or ] in place of "
                "the second @ for one direction",
            )
    return bridges, services


def read_file(path: Path) -> tuple[list[Bridge], list[str]]:
    """Read a bridge's configuration file.

    Returns:
        The topics, and what is wrong with the file, which bridges the rest, as the real one does.
    """
    from teleopctl.base import ros_yaml

    try:
        with ros_yaml.faults_of(path):
            entries = ros_yaml.load(read_text(path))
    except TeleopctlError as error:
        return [], [error.message]
    if not isinstance(entries, list):
        return [], [f"{path}: expected a list of topics"]
    bridges: list[Bridge] = []
    faults: list[str] = []
    for number, entry in enumerate(entries, start=1):
        try:
            bridges.append(_bridge(entry))
        except ValueError as error:
            faults.append(f"{path}: entry {number}: {error}")
    return bridges, faults


def _bridge(entry: object) -> Bridge:
    if not isinstance(entry, dict):
        raise ValueError("expected a mapping")
    name, ros, gz = (
        str(entry.get(key) or "") for key in ("topic_name", "ros_topic_name", "gz_topic_name")
    )
    if name and (ros or gz):
        raise ValueError("topic_name excludes ros_topic_name and gz_topic_name")
    if not (entry.get("ros_type_name") and entry.get("gz_type_name")):
        raise ValueError("ros_type_name and gz_type_name are both needed")
    direction = str(entry.get("direction", "BIDIRECTIONAL"))
    if direction not in _DIRECTIONS.values():
        raise ValueError(f"direction is '{direction}', expected {', '.join(_DIRECTIONS.values())}")
    if not (name or ros or gz):
        raise ValueError("a topic is missing")
    return Bridge(name or ros or gz, name or gz or ros, str(entry["ros_type_name"]), direction)

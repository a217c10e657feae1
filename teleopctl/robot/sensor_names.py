"""The names that a Gazebo plug-in's ``<ros>`` gives to topics.

A plug-in of ``gazebo_ros`` is a node of its own, named as the plug-in, in the ``<namespace>`` of
its ``<ros>``. The rules of its ``<remapping>`` and ``<argument>`` elements apply to this node.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.robot.urdf_text import topic_name

if TYPE_CHECKING:
    from teleopctl.robot.sensor_tag import PluginTag, SensorTag

_RULES = ("ros/remapping", "ros/argument")
_MARK = ":="
# Gazebo writes this name if the description names no topic.
_NO_TOPIC = "__default_topic__"


def ros_topic(name: str) -> str:
    """Return a Gazebo topic name as a valid ROS topic name."""
    start = next((mark for mark in ("~/", "/") if name.startswith(mark)), "")
    return start + topic_name(name.removeprefix(start))


class RosNames:
    """ROS topics and frames of a Gazebo sensor, by its tags and its plug-in's.

    A name without a leading slash is relative to the namespace of the publishing node.

    Args:
        sensor: ``<sensor>`` tag of the description.
    """

    def __init__(self, sensor: SensorTag) -> None:
        self._plugin = next(filter(_is_ros_plugin, sensor.plugins), None)
        self._rules: dict[str, str] = {}
        namespace = ""
        for plugin in sensor.plugins:
            namespace = namespace or plugin.parameter("ros/namespace").rstrip("/")
            for path in _RULES:
                for rule in plugin.parameters.get(path, ()):
                    source, mark, target = rule.removeprefix("-r ").partition(_MARK)
                    if mark:
                        self._rules.setdefault(source.strip(), target.strip())
        self._namespace = f"/{namespace.lstrip('/')}" if namespace else ""
        self.topic = "" if sensor.topic == _NO_TOPIC else sensor.topic
        self._rules = {self._full(source): target for source, target in self._rules.items()}

    @property
    def has_plugin(self) -> bool:
        """Whether a ``gazebo_ros`` plug-in publishes the sensor's data."""
        return self._plugin is not None

    @property
    def topic_decides(self) -> bool:
        """Whether the sensor's ``<topic>`` names its ROS topic, instead of its plug-in.

        True without a ``gazebo_ros`` plug-in, or with a ``<topic>`` and a plug-in without a
        ``<ros>`` element, which is meant for ROS 1.
        """
        of_ros = self._plugin is not None and any(
            path.startswith("ros/") for path in self._plugin.parameters
        )
        return self._plugin is None or bool(self.topic and not of_ros)

    @property
    def plugin_file(self) -> str:
        """File name of the sensor's ``gazebo_ros`` plug-in; empty if there is none."""
        return "" if self._plugin is None else self._plugin.filename

    def setting(self, *paths: str) -> str:
        """Return the first text that the ROS plug-in has at given parameter paths; else empty."""
        texts = () if self._plugin is None else map(self._plugin.parameter, paths)
        return next(filter(None, texts), "")

    def remapped(self, name: str) -> str:
        """Return the name that a ``<remapping>`` gives a plug-in's topic; empty for none."""
        target = self._rules.get(self._full(name))
        return "" if target is None else self._within(target)

    def of_plugin(self, name: str) -> str:
        """Return the ROS name of a plug-in's topic such as ``~/out``, remapped or namespaced."""
        return self.remapped(name) or self._within(name)

    def _full(self, name: str) -> str:
        inside = self._within(name)
        return inside if inside.startswith("/") else f"/{inside}"

    def _within(self, name: str) -> str:
        """Return a name within the plug-in's node and namespace."""
        if name.startswith("~"):
            node = self._plugin.name if self._plugin is not None else ""
            name = f"{node}/{name[1:].lstrip('/')}"
        if name.startswith("/") or not self._namespace:
            return name
        return f"{self._namespace}/{name}"


def _is_ros_plugin(plugin: PluginTag) -> bool:
    return "gazebo_ros" in plugin.filename or any(
        path.startswith("ros/") for path in plugin.parameters
    )

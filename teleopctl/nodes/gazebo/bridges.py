"""Executables ``parameter_bridge``, ``bridge_node`` and ``image_bridge``, as Gazebo's bridges.

Gazebo has messages of its own, which these programs translate in ROS 2. teleopctl's simulator uses
ROS 2 messages, so a topic with the same name on both sides needs no bridge. A topic whose file or
remapping gives another name in ROS is republished under that name. Gazebo has one type for
velocities with and without a stamp; its bases, and so the simulator's, subscribe to those without.

An argument of the command line is ``/topic@ros_type@gz_type``, with ``[`` in place of the second
``@`` for Gazebo to ROS only and ``]`` for ROS to Gazebo only. A file is a list of mappings, whose
topics may have different names in ROS and in Gazebo.
"""

from __future__ import annotations

import contextlib
import re
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Final, NamedTuple

from teleopctl.base.files import read_text
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import deserialize, get_message, serialize
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    Publisher,
    SingleThreadedExecutor,
    init,
    parse_ros_arguments,
)
from teleopctl.robot import ros_topic

_WORD: Final = re.compile(r"([^@]+)@([^@\[\]]+)([@\[\]])([^@\[\]]+)")
_SERVICE: Final = re.compile(r"([^@]+)@([^@\[\]]+/srv/[^@\[\]]+)(@[^@]+@[^@]+)?")
# Gazebo's topic names of a sensor without `<topic>`, and below the names in teleopctl's simulator.
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
    """A topic to bridge between Gazebo and ROS, with both names and the direction.

    Attributes:
        ros_topic: Name of the topic in ROS, before remapping.
        gz_topic: Name of the topic in Gazebo.
        ros_type: Type of the topic in ROS.
        direction: ``GZ_TO_ROS``, ``ROS_TO_GZ`` or ``BIDIRECTIONAL``.
    """

    ros_topic: str
    gz_topic: str
    ros_type: str
    direction: str = "BIDIRECTIONAL"


def simulated_topics(gz_topic: str) -> tuple[str, ...]:
    """Return the names that teleopctl's simulator may use for a Gazebo topic.

    The topics of a robot's only camera are named differently from those of several cameras.
    """
    found = _OF_SENSOR.fullmatch(gz_topic)
    if found is None:
        return (gz_topic,)
    sensor, what = found["sensor"], found[2]
    names = ("{}",) if what in _ALONE else _BELOW.get(what, (f"{{}}/{what}",))
    return tuple(f"/{ros_topic(name.format(sensor))}" for name in names)


def parse_bridge_arguments(arguments: Sequence[str]) -> tuple[list[Bridge], list[str]]:
    """Parse ``parameter_bridge``'s arguments; return a pair: bridges, and names of services.

    Raises:
        UsageError: An argument names neither a topic nor a service.
    """
    bridges: list[Bridge] = []
    services: list[str] = []
    for word in arguments:
        if service := _SERVICE.fullmatch(word):
            services.append(service[1])
        elif topic := _WORD.fullmatch(word):
            bridges.append(Bridge(topic[1], topic[1], topic[2], _DIRECTIONS[topic[3]]))
        else:
            raise UsageError(
                f"'{word}' is not a topic to bridge",
                hint="Usage: parameter_bridge TOPIC@ROS_TYPE@GZ_TYPE …, with [ or ] in place of "
                "the second @ for one direction",
            )
    return bridges, services


def read_bridge_file(path: Path) -> tuple[list[Bridge], list[str]]:
    """Read a ros_gz_bridge file; return a pair: valid bridges, and messages of errors.

    Returns:
        Topics to bridge, and error messages of the invalid entries, which are skipped as in
        ros_gz_bridge.
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
            bridges.append(_entry_bridge(entry))
        except ValueError as error:
            faults.append(f"{path}: entry {number}: {error}")
    return bridges, faults


def _entry_bridge(entry: object) -> Bridge:
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


_TWIST, _STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
_IMAGE = "sensor_msgs/msg/Image"
# Queue depth of ros_gz_bridge.
_DEPTH = 10


def parameter_bridge() -> int:
    """Run ``parameter_bridge`` until Ctrl-C: republish topics whose ROS name or twist type differs.

    Raises:
        UsageError: An argument names neither a topic nor a service.
    """
    bridges, services = parse_bridge_arguments(parse_ros_arguments(sys.argv[1:]).program)
    with _bridging("ros_gz_bridge") as (node, simulators):
        for service in services:
            node.get_logger().warning(
                f"Service {service} does not exist: the simulator's services are below /mujoco_sim"
            )
        node.declare_parameter("lazy", False)
        node.declare_parameter("subscription_heartbeat", 1000)
        if node.declare_parameter("override_timestamps_with_wall_time", False).value:
            node.get_logger().warning("Without effect here: override_timestamps_with_wall_time")
        expands = node.declare_parameter("expand_gz_topic_names", False).value
        file = str(node.declare_parameter("config_file", "").value)
        if file:
            read, faults = read_bridge_file(Path(file))
            for fault in faults:
                node.get_logger().error(fault)
            bridges += [
                bridge._replace(gz_topic=f"{node.get_namespace().rstrip('/')}/{bridge.gz_topic}")
                if expands and not bridge.gz_topic.startswith("/")
                else bridge
                for bridge in read
            ]
        _bridge(node, simulators, bridges)
        _spin(node, simulators)
    return 0


def image_bridge() -> int:
    """Run ``image_bridge`` until Ctrl-C: republish images whose ROS and Gazebo names differ.

    Raises:
        UsageError: The command line names no topic.
    """
    topics = parse_ros_arguments(sys.argv[1:]).program
    if not topics:
        raise UsageError("There is no topic to bridge", hint="Usage: image_bridge TOPIC …")
    with _bridging("ros_gz_image") as (node, simulators):
        node.declare_parameter("qos", "default")
        _bridge(node, simulators, [Bridge(name, name, _IMAGE, "GZ_TO_ROS") for name in topics])
        _spin(node, simulators)
    return 0


@contextlib.contextmanager
def _bridging(name: str) -> Iterator[tuple[Node, Node]]:
    """Yield a node for ROS, with remappings, and a node for the simulator, without remappings."""
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(),
        Node(name) as node,
        Node(f"_{node.get_name()}_gz", use_global_arguments=False) as simulators,
    ):
        yield node, simulators


def _bridge(node: Node, simulators: Node, bridges: list[Bridge]) -> None:
    """Republish the topics that have two names, and log those that need no bridge."""
    same: list[str] = []
    for bridge in bridges:
        ros = node.resolve_topic_name(bridge.ros_topic)
        topics = simulated_topics(f"/{bridge.gz_topic.lstrip('/')}")
        gz = topics[0]
        if ros == gz and bridge.ros_type != _STAMPED:
            same.append(gz)
            continue
        try:
            message = get_message(bridge.ros_type)
        except TeleopctlError as error:
            node.get_logger().warning(f"Topic {ros} is not passed on: {error.message}")
            continue
        stamps = bridge.ros_type == _STAMPED
        there = get_message(_TWIST) if stamps else message
        sides = [_Side(simulators, topic, there) for topic in topics]
        in_ros = _Side(node, bridge.ros_topic, message)
        without = " without stamps" if stamps else ""
        if bridge.direction != "ROS_TO_GZ":
            node.get_logger().info(f"Passing on {' or '.join(topics)}{without} as {ros}")
            for in_gazebo in sides:
                in_gazebo.pass_to(in_ros, partial(_with_stamp, node) if stamps else None)
        if bridge.direction != "GZ_TO_ROS":
            node.get_logger().info(f"Passing on {ros} as {gz}{without}")
            in_ros.pass_to(sides[0], _without_stamp if stamps else None)
    if same or not bridges:
        listed = ", ".join(same) or "its topics"
        node.get_logger().info(
            f"The simulator publishes ROS 2 topics itself: no bridge is needed for {listed}"
        )


class _Side:
    """A topic on one of the two sides of a bridge.

    In a bidirectional bridge, messages that this side published are received again and dropped.
    """

    def __init__(self, node: Node, topic: str, message: type[Any]) -> None:
        self._node = node
        self._topic = topic
        self._message = message
        self._echoes: deque[bytes] = deque(maxlen=_DEPTH)

    @cached_property
    def _publisher(self) -> Publisher[Any]:
        return self._node.create_publisher(self._message, self._topic, _DEPTH)

    def pass_to(self, other: _Side, convert: Callable[[bytes], bytes] | None = None) -> None:
        """Republish messages of this side's topic on the other side, converted by ``convert``."""
        publisher = other._publisher

        def pass_on(data: bytes) -> None:
            if data in self._echoes:
                self._echoes.remove(data)
                return
            if convert is not None:
                data = convert(data)
            other._echoes.append(data)
            publisher.publish(data)

        self._node.create_subscription(self._message, self._topic, pass_on, _DEPTH, raw=True)


def _with_stamp(node: Node, data: bytes) -> bytes:
    message = get_message(_STAMPED)(twist=deserialize(data, get_message(_TWIST)))
    message.header.stamp = node.get_clock().now().to_msg()
    return bytes(serialize(message))


def _without_stamp(data: bytes) -> bytes:
    return bytes(serialize(deserialize(data, get_message(_STAMPED)).twist))


def _spin(node: Node, simulators: Node) -> None:
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    executor.add_node(simulators)
    executor.spin()

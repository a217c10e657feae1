"""``parameter_bridge`` and ``image_bridge``: nothing is to be bridged, and they say so.

Gazebo has messages of its own, which these programs of ROS 2 translate; the simulator here speaks
ROS 2 itself. They stay until they are stopped, since a launch may wait for them.
"""

from __future__ import annotations

import contextlib
import sys

from teleopctl.node import ExternalShutdownException, Node, init, parse_ros_arguments, spin


def parameter_bridge() -> int:
    """Stand for ``ros_gz_bridge parameter_bridge``."""
    words = parse_ros_arguments(sys.argv[1:]).program
    # /topic@ros/type@gz.type, with [ or ] in place of the second @ for one direction.
    topics = [word.partition("@")[0] for word in words if not word.startswith("-")]
    return _stay("ros_gz_bridge", topics, ("config_file",))


def image_bridge() -> int:
    """Stand for ``ros_gz_image image_bridge``."""
    words = parse_ros_arguments(sys.argv[1:]).program
    topics = [word for word in words if not word.startswith("-")]
    return _stay("ros_gz_image", topics, ())


def _stay(name: str, topics: list[str], files: tuple[str, ...]) -> int:
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(),
        Node(name) as node,
    ):
        named = [*topics, *(str(node.declare_parameter(file, "").value) for file in files)]
        told = ", ".join(filter(None, named)) or "its topics"
        node.get_logger().info(f"The simulator speaks ROS 2: no bridge is needed for {told}")
        spin(node)
    return 0

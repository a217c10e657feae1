"""Launch file of a talker and a listener."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return a launch of the nodes ``talker`` and ``listener``."""
    return LaunchDescription(
        [
            Node(package="demo_nodes_cpp", executable=executable, output="screen")
            for executable in ("talker", "listener")
        ]
    )

"""Launch file of a service and a client whose calls can be watched."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return a launch of the nodes ``introspection_service`` and ``introspection_client``."""
    return LaunchDescription(
        [
            Node(package="demo_nodes_cpp", executable=executable, output="screen")
            for executable in ("introspection_service", "introspection_client")
        ]
    )

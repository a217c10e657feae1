"""Launch file of the lifecycle demo; it ends with the client of the talker's transitions."""

from launch import LaunchDescription
from launch.actions import Shutdown
from launch_ros.actions import LifecycleNode, Node


def generate_launch_description() -> LaunchDescription:
    """Return a launch of talker, listener and client that shuts down when the client exits."""
    return LaunchDescription(
        [
            LifecycleNode(
                package="lifecycle",
                executable="lifecycle_talker",
                name="lc_talker",
                namespace="",
                output="screen",
            ),
            Node(package="lifecycle", executable="lifecycle_listener", output="screen"),
            Node(
                package="lifecycle",
                executable="lifecycle_service_client",
                output="screen",
                on_exit=Shutdown(),
            ),
        ]
    )

"""Two simulations of turtles, each with a window and a namespace of its own."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Start turtlesim in the namespaces turtlesim1 and turtlesim2."""
    return LaunchDescription(
        [
            Node(
                package="turtlesim",
                executable="turtlesim_node",
                namespace=f"turtlesim{number}",
                output="screen",
            )
            for number in (1, 2)
        ]
    )

"""Says where the picture of Gazebo's window is."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch_ros.actions import Node

IGNORED = {
    "version": "false",
    "verbose": "false",
    "help": "false",
    "extra_gazebo_args": "",
    "gdb": "false",
    "valgrind": "false",
    "gui_required": "false",
}


def generate_launch_description() -> LaunchDescription:
    """Return what is to be launched."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description="Without effect.")
                for name, default in IGNORED.items()
            ),
            Node(package="gazebo_ros", executable="gzclient", output="screen"),
        ]
    )

"""Launch file ``gz_server``: starts the simulator without a window."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "world_sdf_file": ("", "World to simulate: path or name of a world file."),
    "world_sdf_string": ("", "World to simulate, as SDF text."),
    "container_name": (
        "ros_gz_container",
        "Component container for composition; without effect here.",
    ),
    "create_own_container": (
        "False",
        "Whether to start the component container; without effect here.",
    ),
    "use_composition": (
        "False",
        "Whether to use composition; the simulator is always a separate process.",
    ),
}


def generate_launch_description() -> LaunchDescription:
    """Return the launch arguments, and the node ``gzserver``, the simulator without window."""
    worlds = ("world_sdf_file", "world_sdf_string")
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            LogInfo(
                msg="use_composition: the simulator is a process of its own here",
                condition=IfCondition(LaunchConfiguration("use_composition")),
            ),
            Node(
                package="ros_gz_sim",
                executable="gzserver",
                output="screen",
                parameters=[{name: LaunchConfiguration(name) for name in worlds}],
            ),
        ]
    )

"""Launch file ``gz_server``: starts the simulator without a window."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "world_sdf_file": ("", "A world: its file, or its name."),
    "world_sdf_string": ("", "A world as text."),
    "container_name": ("ros_gz_container", "Where it would be loaded."),
    "create_own_container": ("False", "Whether a container of its own would be created."),
    "use_composition": ("False", "Whether it would be loaded into a container."),
}


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the process ``gzserver``."""
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

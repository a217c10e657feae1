"""Launch file ``ros_gz_bridge``: starts the bridge of a configuration file."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "container_name": ("ros_gz_container", "Where it would be loaded."),
    "create_own_container": ("False", "Whether a container of its own would be created."),
    "namespace": ("", "Its namespace."),
    "use_composition": ("False", "Whether it would be loaded into a container."),
    "use_respawn": ("False", "Whether it is started again when it ends."),
    "log_level": ("info", "The lowest level of its messages."),
}


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the node ``bridge_node``."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("bridge_name", description="The bridge's name."),
            DeclareLaunchArgument("config_file", description="The file of its topics."),
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            LogInfo(
                msg="use_composition: the bridge is a process of its own here",
                condition=IfCondition(LaunchConfiguration("use_composition")),
            ),
            Node(
                package="ros_gz_bridge",
                executable="bridge_node",
                name=LaunchConfiguration("bridge_name"),
                namespace=LaunchConfiguration("namespace"),
                output="screen",
                respawn=LaunchConfiguration("use_respawn"),
                respawn_delay=2.0,
                parameters=[{"config_file": LaunchConfiguration("config_file")}],
                ros_arguments=["--log-level", LaunchConfiguration("log_level")],
            ),
        ]
    )

"""Launch file ``ros_gz_bridge``: starts the bridge of a configuration file."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "container_name": (
        "ros_gz_container",
        "Component container for composition; without effect here.",
    ),
    "create_own_container": (
        "False",
        "Whether to start the component container; without effect here.",
    ),
    "namespace": ("", "Namespace of the bridge node."),
    "use_composition": (
        "False",
        "Whether to use composition; the bridge is always a separate process.",
    ),
    "use_respawn": ("False", "Whether to restart the bridge node when it exits."),
    "log_level": ("info", "Log level of the bridge node."),
}


def generate_launch_description() -> LaunchDescription:
    """Return the declared launch arguments, and the node ``bridge_node`` that uses them."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("bridge_name", description="Name of the bridge node."),
            DeclareLaunchArgument(
                "config_file", description="YAML file that lists the topics to bridge."
            ),
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

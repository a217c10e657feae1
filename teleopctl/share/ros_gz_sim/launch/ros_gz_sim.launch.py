"""Launch file ``ros_gz_sim``: starts the simulator and a bridge of its topics."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare

SERVER = (
    "world_sdf_file",
    "world_sdf_string",
    "container_name",
    "create_own_container",
    "use_composition",
)
BRIDGE = (
    "bridge_name",
    "config_file",
    "container_name",
    "namespace",
    "use_composition",
    "use_respawn",
)
DEFAULTS = {
    "container_name": "ros_gz_container",
    "create_own_container": "False",
    "namespace": "",
    "use_composition": "False",
    "use_respawn": "False",
    "bridge_log_level": "info",
    "world_sdf_file": "",
    "world_sdf_string": "",
}


def part(package: str, file: str, arguments: dict[str, str]) -> IncludeLaunchDescription:
    """Return the inclusion of a launch file; its arguments are set to arguments of this file."""
    return IncludeLaunchDescription(
        PathJoinSubstitution([FindPackageShare(package), "launch", file]),
        launch_arguments=[
            (name, LaunchConfiguration(source)) for name, source in arguments.items()
        ],
    )


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the included launch files of simulator and bridge."""
    bridge = {name: name for name in BRIDGE} | {"log_level": "bridge_log_level"}
    return LaunchDescription(
        [
            DeclareLaunchArgument("bridge_name", description="The bridge's name."),
            DeclareLaunchArgument("config_file", description="The file of its topics."),
            *(
                DeclareLaunchArgument(name, default_value=default)
                for name, default in DEFAULTS.items()
            ),
            part("ros_gz_sim", "gz_server.launch.py", {name: name for name in SERVER}),
            part("ros_gz_bridge", "ros_gz_bridge.launch.py", bridge),
        ]
    )

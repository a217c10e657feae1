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
    """Return an action that includes a launch file; the dictionary maps its arguments to ours."""
    return IncludeLaunchDescription(
        PathJoinSubstitution([FindPackageShare(package), "launch", file]),
        launch_arguments=[
            (name, LaunchConfiguration(source)) for name, source in arguments.items()
        ],
    )


def generate_launch_description() -> LaunchDescription:
    """Return a launch that includes the launch files of the simulator and the bridge."""
    bridge = {name: name for name in BRIDGE} | {"log_level": "bridge_log_level"}
    return LaunchDescription(
        [
            DeclareLaunchArgument("bridge_name", description="Name of the bridge node."),
            DeclareLaunchArgument(
                "config_file", description="YAML file that lists the topics to bridge."
            ),
            *(
                DeclareLaunchArgument(name, default_value=default)
                for name, default in DEFAULTS.items()
            ),
            part("ros_gz_sim", "gz_server.launch.py", {name: name for name in SERVER}),
            part("ros_gz_bridge", "ros_gz_bridge.launch.py", bridge),
        ]
    )

"""Launch file ``ros_gz_spawn_model``: spawns an entity, and starts a bridge of topics."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare

BRIDGE = {
    "bridge_name": None,
    "config_file": None,
    "container_name": "ros_gz_container",
    "namespace": "",
    "use_composition": "True",
    "use_respawn": "False",
    "log_level": "info",
}
MODEL = {
    "world": "",
    "file": "",
    "model_string": "",
    "topic": "",
    "entity_name": "",
    "allow_renaming": "False",
}
POSE = ("x", "y", "z", "R", "P", "Y")


def part(package: str, file: str, names: list[str]) -> IncludeLaunchDescription:
    """Return an action that includes a launch file and passes on arguments by name."""
    arguments = [
        (name, LaunchConfiguration(name, default="0.0" if name in POSE else None)) for name in names
    ]
    return IncludeLaunchDescription(
        PathJoinSubstitution([FindPackageShare(package), "launch", file]),
        launch_arguments=arguments,
    )


def generate_launch_description() -> LaunchDescription:
    """Return a launch that includes the launch files of spawning and of the bridge."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default)
                for name, default in (BRIDGE | MODEL).items()
            ),
            part("ros_gz_bridge", "ros_gz_bridge.launch.py", [*BRIDGE]),
            part("ros_gz_sim", "gz_spawn_model.launch.py", [*MODEL, *POSE]),
        ]
    )

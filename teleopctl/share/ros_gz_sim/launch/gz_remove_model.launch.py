"""Launch file ``gz_remove_model``: deletes an entity from the simulator."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "world": "Name of the world; without effect, since there is one world.",
    "entity_name": "Name of the entity to delete.",
}


def generate_launch_description() -> LaunchDescription:
    """Return the launch arguments, and the node ``remove``, which deletes the entity."""
    values = {name: ParameterValue(LaunchConfiguration(name), value_type=str) for name in ARGUMENTS}
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value="", description=description)
                for name, description in ARGUMENTS.items()
            ),
            Node(package="ros_gz_sim", executable="remove", output="screen", parameters=[values]),
        ]
    )

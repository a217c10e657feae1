"""Launch file ``gz_spawn_model``: spawns an entity in the simulator."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# Argument of this file: parameter of `create`, default and description.
TEXTS = {
    "world": ("world", "", "Name of the world; without effect, since there is one world."),
    "file": ("file", "", "SDF or URDF file that describes the entity."),
    "model_string": ("string", "", "SDF or URDF text that describes the entity."),
    "topic": ("topic", "", "Topic on which the SDF or URDF text is published."),
    "entity_name": ("name", "", "Name of the entity."),
    "allow_renaming": (
        "allow_renaming",
        "False",
        "Whether to rename the entity if its name is taken.",
    ),
}
POSE = ("x", "y", "z", "R", "P", "Y")


def generate_launch_description() -> LaunchDescription:
    """Return the launch arguments, and the node ``create``, which spawns the entity."""
    texts = {
        parameter: ParameterValue(
            LaunchConfiguration(name), value_type=bool if default == "False" else str
        )
        for name, (parameter, default, _) in TEXTS.items()
    }
    numbers = {
        name: ParameterValue(LaunchConfiguration(name, default="0.0"), value_type=float)
        for name in POSE
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (_, default, description) in TEXTS.items()
            ),
            Node(
                package="ros_gz_sim",
                executable="create",
                output="screen",
                parameters=[texts | numbers],
            ),
        ]
    )

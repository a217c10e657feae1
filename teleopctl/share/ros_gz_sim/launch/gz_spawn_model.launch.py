"""Launch file ``gz_spawn_model``: spawns an entity in the simulator."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# Argument of this file: parameter of `create`, default and description.
TEXTS = {
    "world": ("world", "", "The world's name; there is one world."),
    "file": ("file", "", "The file of its description."),
    "model_string": ("string", "", "Its description as text."),
    "topic": ("topic", "", "The topic of its description."),
    "entity_name": ("name", "", "Its name."),
    "allow_renaming": ("allow_renaming", "False", "Whether it may get another name."),
}
POSE = ("x", "y", "z", "R", "P", "Y")


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the node ``create``, which spawns the entity."""
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

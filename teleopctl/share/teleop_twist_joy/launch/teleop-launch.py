"""A gamepad that drives a mobile robot: the driver of the gamepad, and teleop_twist_joy."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Start both nodes with the numbers of one kind of gamepad."""
    folder = PathJoinSubstitution([FindPackageShare("teleop_twist_joy"), "config", ""])
    config = [folder, LaunchConfiguration("joy_config"), ".config.yaml"]
    return LaunchDescription(
        [
            DeclareLaunchArgument("joy_vel", default_value="cmd_vel"),
            DeclareLaunchArgument("joy_config", default_value="ps3"),
            DeclareLaunchArgument("joy_dev", default_value="0"),
            DeclareLaunchArgument("publish_stamped_twist", default_value="false"),
            DeclareLaunchArgument("config_filepath", default_value=config),
            Node(
                package="joy",
                executable="joy_node",
                name="joy_node",
                parameters=[
                    {
                        "device_id": LaunchConfiguration("joy_dev"),
                        "deadzone": 0.3,
                        "autorepeat_rate": 20.0,
                    },
                    LaunchConfiguration("config_filepath"),
                ],
            ),
            Node(
                package="teleop_twist_joy",
                executable="teleop_node",
                name="teleop_twist_joy_node",
                parameters=[
                    LaunchConfiguration("config_filepath"),
                    {"publish_stamped_twist": LaunchConfiguration("publish_stamped_twist")},
                ],
                remappings=[("/cmd_vel", LaunchConfiguration("joy_vel"))],
            ),
        ]
    )

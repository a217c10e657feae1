"""Launch file ``gazebo``: includes ``gzserver``, and ``gzclient`` if ``gui`` is true."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, ThisLaunchFileDir


def part(name: str, condition: str) -> IncludeLaunchDescription:
    """Return the conditional inclusion of a launch file in the same folder."""
    return IncludeLaunchDescription(
        PathJoinSubstitution([ThisLaunchFileDir(), name]),
        condition=IfCondition(LaunchConfiguration(condition)),
    )


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the included ``gzserver`` and ``gzclient``."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gui", default_value="true", description="Whether to print the address of the page."
            ),
            DeclareLaunchArgument(
                "server", default_value="true", description="Whether to simulate."
            ),
            part("gzserver.launch.py", "server"),
            part("gzclient.launch.py", "gui"),
        ]
    )

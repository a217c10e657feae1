"""Launch file ``gazebo``: includes ``gzserver``, and ``gzclient`` if ``gui`` is true."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, ThisLaunchFileDir


def part(name: str, condition: str) -> IncludeLaunchDescription:
    """Return the inclusion of a file that stands beside this one."""
    return IncludeLaunchDescription(
        PathJoinSubstitution([ThisLaunchFileDir(), name]),
        condition=IfCondition(LaunchConfiguration(condition)),
    )


def generate_launch_description() -> LaunchDescription:
    """Return what is to be launched."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gui", default_value="true", description="Whether to say where the picture is."
            ),
            DeclareLaunchArgument(
                "server", default_value="true", description="Whether to simulate."
            ),
            part("gzserver.launch.py", "server"),
            part("gzclient.launch.py", "gui"),
        ]
    )

"""Launch file ``gazebo``: includes ``gzserver``, and ``gzclient`` if ``gui`` is true."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, ThisLaunchFileDir


def part(name: str, condition: str) -> IncludeLaunchDescription:
    """Return an action that includes a launch file of this folder if an argument is true."""
    return IncludeLaunchDescription(
        PathJoinSubstitution([ThisLaunchFileDir(), name]),
        condition=IfCondition(LaunchConfiguration(condition)),
    )


def generate_launch_description() -> LaunchDescription:
    """Return a launch that includes ``gzserver`` and ``gzclient``, each if its argument is true."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gui",
                default_value="true",
                description="Whether to start gzclient, which prints the address of the web page.",
            ),
            DeclareLaunchArgument(
                "server",
                default_value="true",
                description="Whether to start gzserver, the simulator.",
            ),
            part("gzserver.launch.py", "server"),
            part("gzclient.launch.py", "gui"),
        ]
    )

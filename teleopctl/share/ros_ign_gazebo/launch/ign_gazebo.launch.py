"""Launch file ``ign_gazebo``: ``gz_sim`` of ``ros_gz_sim`` by its older name."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the declared launch argument, and the include of ``gz_sim.launch.py`` with it."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "ign_args",
                default_value="",
                description="Arguments of `gz sim`: world file and options, -r to start unpaused.",
            ),
            DeclareLaunchArgument(
                "ign_version",
                default_value="",
                description="Major version of Gazebo Sim; without effect, since MuJoCo simulates.",
            ),
            IncludeLaunchDescription(
                PathJoinSubstitution(
                    [FindPackageShare("ros_gz_sim"), "launch", "gz_sim.launch.py"]
                ),
                launch_arguments=[("gz_args", LaunchConfiguration("ign_args"))],
            ),
        ]
    )

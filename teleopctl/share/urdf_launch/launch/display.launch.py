"""Launch file ``display``: shows a package's robot on the web page, with joint sliders."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return a launch of robot_state_publisher, a joint state publisher and RViz (the web page)."""
    share = FindPackageShare("urdf_launch")
    wants_sliders = LaunchConfiguration("jsp_gui")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "jsp_gui",
                default_value="true",
                choices=["true", "false"],
                description="Whether to show sliders for the joints (joint_state_publisher_gui).",
            ),
            DeclareLaunchArgument(
                "rviz_config",
                default_value=PathJoinSubstitution([share, "config", "urdf.rviz"]),
                description="RViz configuration file (.rviz) to load.",
            ),
            IncludeLaunchDescription(
                PathJoinSubstitution([share, "launch", "description.launch.py"]),
                launch_arguments={
                    "urdf_package": LaunchConfiguration("urdf_package"),
                    "urdf_package_path": LaunchConfiguration("urdf_package_path"),
                }.items(),
            ),
            Node(
                package="joint_state_publisher",
                executable="joint_state_publisher",
                condition=UnlessCondition(wants_sliders),
            ),
            Node(
                package="joint_state_publisher_gui",
                executable="joint_state_publisher_gui",
                condition=IfCondition(wants_sliders),
            ),
            Node(
                package="rviz2",
                executable="rviz2",
                output="screen",
                arguments=["-d", LaunchConfiguration("rviz_config")],
            ),
        ]
    )

"""Launch file ``display``: shows a robot on the web page, with joint sliders."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the inclusion of urdf_launch's display."""
    display = FindPackageShare("urdf_launch")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gui",
                default_value="true",
                choices=["true", "false"],
                description="Whether joint_state_publisher_gui's sliders move the joints.",
            ),
            DeclareLaunchArgument(
                "rvizconfig",
                default_value=PathJoinSubstitution([display, "config", "urdf.rviz"]),
                description="An .rviz file to start with.",
            ),
            DeclareLaunchArgument(
                "model",
                default_value=PathJoinSubstitution(["urdf", "01-myfirst.urdf"]),
                description="A URDF or xacro file, from urdf_tutorial's share folder.",
            ),
            IncludeLaunchDescription(
                PathJoinSubstitution([display, "launch", "display.launch.py"]),
                launch_arguments=[
                    ("urdf_package", "urdf_tutorial"),
                    ("urdf_package_path", LaunchConfiguration("model")),
                    ("rviz_config", LaunchConfiguration("rvizconfig")),
                    ("jsp_gui", LaunchConfiguration("gui")),
                ],
            ),
        ]
    )

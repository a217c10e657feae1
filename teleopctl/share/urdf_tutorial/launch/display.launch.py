"""Launch file ``display``: shows a robot on the web page, with joint sliders."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return a launch that includes urdf_launch's ``display`` for a model of urdf_tutorial."""
    display = FindPackageShare("urdf_launch")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gui",
                default_value="true",
                choices=["true", "false"],
                description="Whether to show sliders for the joints (joint_state_publisher_gui).",
            ),
            DeclareLaunchArgument(
                "rvizconfig",
                default_value=PathJoinSubstitution([display, "config", "urdf.rviz"]),
                description="RViz configuration file (.rviz) to load.",
            ),
            DeclareLaunchArgument(
                "model",
                default_value=PathJoinSubstitution(["urdf", "01-myfirst.urdf"]),
                description="URDF or xacro file, relative to urdf_tutorial's share folder.",
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

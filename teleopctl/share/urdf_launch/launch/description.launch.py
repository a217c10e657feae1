"""Launch file ``description``: starts robot_state_publisher with a package's URDF."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return a launch of robot_state_publisher with the URDF or xacro file of a package."""
    path = PathJoinSubstitution(
        [
            FindPackageShare(LaunchConfiguration("urdf_package")),
            LaunchConfiguration("urdf_package_path"),
        ]
    )
    description = ParameterValue(Command(["xacro ", path]), value_type=str)
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "urdf_package", description="Package that contains the robot description."
            ),
            DeclareLaunchArgument(
                "urdf_package_path",
                description="URDF or xacro file, relative to the package's share folder.",
            ),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[{"robot_description": description}],
            ),
        ]
    )

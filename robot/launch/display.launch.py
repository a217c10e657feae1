"""The arm to look at: its frames, sliders for its joints, and RViz."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Describe what is started."""
    model = PathJoinSubstitution(
        [FindPackageShare("teleop_description"), "urdf", "teleop.urdf.xacro"]
    )
    description = ParameterValue(Command(["xacro ", LaunchConfiguration("model")]), value_type=str)
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "model", default_value=model, description="Absolute path to the robot's URDF file"
            ),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[{"robot_description": description}],
            ),
            Node(package="joint_state_publisher_gui", executable="joint_state_publisher_gui"),
            Node(package="rviz2", executable="rviz2", name="rviz2", output="screen"),
        ]
    )

"""The arm in Gazebo's launch files: the simulator, its controller manager, and the arm in it."""

import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, SetEnvironmentVariable
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackagePrefix, FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Describe what is started."""
    description_share = FindPackageShare("teleop_description")
    gazebo_launch = PathJoinSubstitution([FindPackageShare("gazebo_ros"), "launch"])
    controllers = PathJoinSubstitution(
        [FindPackageShare("teleop_controller"), "teleop_controllers.yaml"]
    )
    description = ParameterValue(
        Command(["xacro ", LaunchConfiguration("model"), " controllers_file:=", controllers]),
        value_type=str,
    )
    return LaunchDescription(
        [
            SetEnvironmentVariable(
                "GAZEBO_MODEL_PATH",
                [FindPackagePrefix("teleop_description"), os.pathsep, description_share],
            ),
            DeclareLaunchArgument(
                "model",
                default_value=PathJoinSubstitution(
                    [description_share, "urdf", "teleop.urdf.xacro"]
                ),
                description="Absolute path to the robot's URDF file",
            ),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[{"robot_description": description, "use_sim_time": True}],
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource([gazebo_launch, "/gzserver.launch.py"])
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource([gazebo_launch, "/gzclient.launch.py"])
            ),
            Node(
                package="gazebo_ros",
                executable="spawn_entity.py",
                arguments=["-entity", "teleop", "-topic", "robot_description"],
                output="screen",
            ),
        ]
    )

"""Starts Gazebo's simulator, which is MuJoCo here."""

import shlex

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the simulator, with the arguments that Gazebo would be given."""

    def value(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    stays = value("on_exit_shutdown") == "false"
    return [
        Node(
            package="ros_gz_sim",
            executable="gz",
            exec_name="gazebo",
            output="screen",
            arguments=["sim", *shlex.split(value("gz_args") or value("ign_args"))],
            on_exit=None if stays else [Shutdown()],
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Return what is to be launched."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gz_args",
                default_value="",
                description="Arguments of `gz sim`; -r: time passes from the start.",
            ),
            DeclareLaunchArgument(
                "gz_version", default_value="8", description="Without effect: there is MuJoCo."
            ),
            DeclareLaunchArgument(
                "ign_args", default_value="", description="The older name of gz_args."
            ),
            DeclareLaunchArgument(
                "ign_version", default_value="", description="The older name of gz_version."
            ),
            DeclareLaunchArgument("debugger", default_value="false", description="Without effect."),
            DeclareLaunchArgument(
                "on_exit_shutdown",
                default_value="false",
                description="Whether everything ends with the simulator.",
            ),
            OpaqueFunction(function=start),
        ]
    )

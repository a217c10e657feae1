"""Launch file ``gz_sim``: starts the simulator, MuJoCo in place of Gazebo."""

import shlex

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

VERSION = "8"


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the ``gz sim`` node for the launch arguments, and a warning if ``ign_args`` is set."""

    def value(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    version = value("ign_version") or value("gz_version")
    wanted = [] if version == VERSION else ["--force-version", version]
    stays = value("on_exit_shutdown") == "false"
    debugs = value("debugger") != "false"
    simulator = Node(
        package="ros_gz_sim",
        executable="gz",
        exec_name="gazebo",
        output="screen",
        arguments=["sim", *shlex.split(value("gz_args") or value("ign_args")), *wanted],
        prefix="x-terminal-emulator -e gdb -ex run --args" if debugs else None,
        on_exit=None if stays else [Shutdown()],
    )
    if value("ign_args") and not value("gz_args"):
        return [LogInfo(msg="ign_args is deprecated, migrate to gz_args!"), simulator]
    return [simulator]


def generate_launch_description() -> LaunchDescription:
    """Return the declared launch arguments, and the ``gz sim`` node that uses them."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gz_args",
                default_value="",
                description="Arguments of `gz sim`: world file and options, -r to start unpaused.",
            ),
            DeclareLaunchArgument(
                "gz_version",
                default_value=VERSION,
                description="Major version of Gazebo Sim; without effect, since MuJoCo simulates.",
            ),
            DeclareLaunchArgument(
                "ign_args", default_value="", description="Deprecated name of gz_args."
            ),
            DeclareLaunchArgument(
                "ign_version", default_value="", description="Deprecated name of gz_version."
            ),
            DeclareLaunchArgument(
                "debugger",
                default_value="false",
                description="Whether to run the simulator in gdb.",
            ),
            DeclareLaunchArgument(
                "on_exit_shutdown",
                default_value="false",
                description="Whether to shut down the launch when the simulator exits.",
            ),
            OpaqueFunction(function=start),
        ]
    )

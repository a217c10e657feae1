"""Launch file ``gzclient``: logs how to open the web page in place of Gazebo's window."""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

FLAGS = ("version", "verbose", "help")
DEFAULTS = {
    **dict.fromkeys(FLAGS, "false"),
    "extra_gazebo_args": "",
    "gdb": "false",
    "valgrind": "false",
    "gui_required": "false",
}
DEBUGGERS = {"gdb": "gdb -ex run --args", "valgrind": "valgrind"}


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the ``gzclient`` node with a command line built from the launch arguments."""

    def value(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    def is_set(name: str) -> bool:
        return value(name).lower() == "true"

    return [
        Node(
            package="gazebo_ros",
            executable="gzclient",
            output="screen",
            arguments=[
                *(f"--{name}" for name in FLAGS if is_set(name)),
                *value("extra_gazebo_args").split(),
            ],
            prefix=next((words for name, words in DEBUGGERS.items() if is_set(name)), None),
            on_exit=[Shutdown()] if is_set("gui_required") else None,
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Return the declared launch arguments, and the ``gzclient`` node that uses them."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default)
                for name, default in DEFAULTS.items()
            ),
            OpaqueFunction(function=start),
        ]
    )

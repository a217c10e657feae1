"""Launch file ``gzserver``: starts the simulator, MuJoCo in place of Gazebo classic."""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

# Options of gzserver; the program reports those that have no effect.
FLAGS = ("version", "verbose", "lockstep", "help", "pause", "record", "minimal_comms")
VALUES = (
    "initial_sim_time",
    "physics",
    "play",
    "record_encoding",
    "record_path",
    "record_period",
    "record_filter",
    "seed",
    "iters",
    "profile",
)
PLUGINS = ("init", "factory", "force_system")
DEBUGGERS = {"gdb": "gdb -ex run --args", "valgrind": "valgrind"}
OTHERS = {
    "world": ("", "World to simulate: path or name of a world file."),
    "params_file": ("", "YAML file with ROS parameters for the simulator."),
    "extra_gazebo_args": ("", "Additional command-line arguments of gzserver."),
    "server_required": ("false", "Whether to shut down the launch when gzserver exits."),
    "gdb": ("false", "Whether to run gzserver in gdb."),
    "valgrind": ("false", "Whether to run gzserver in valgrind."),
}


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the ``gzserver`` node with a command line built from the launch arguments."""

    def value(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    def is_set(name: str) -> bool:
        return value(name).lower() == "true"

    words = [
        *filter(None, [value("world")]),
        *(f"--{name}" for name in FLAGS if is_set(name)),
        *(word for name in VALUES if value(name) for word in (f"--{name}", value(name))),
        *(word for name in PLUGINS if is_set(name) for word in ("-s", f"libgazebo_ros_{name}.so")),
        *value("extra_gazebo_args").split(),
    ]
    return [
        Node(
            package="gazebo_ros",
            executable="gzserver",
            output="screen",
            arguments=words,
            parameters=list(filter(None, [value("params_file")])),
            prefix=next((words for name, words in DEBUGGERS.items() if is_set(name)), None),
            on_exit=[Shutdown()] if is_set("server_required") else None,
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Return the declared launch arguments, and the ``gzserver`` node that uses them."""
    defaults = {
        **dict.fromkeys(FLAGS, "false"),
        **dict.fromkeys(VALUES, ""),
        **dict.fromkeys(PLUGINS, "true"),
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in OTHERS.items()
            ),
            *(
                DeclareLaunchArgument(name, default_value=default)
                for name, default in defaults.items()
            ),
            OpaqueFunction(function=start),
        ]
    )

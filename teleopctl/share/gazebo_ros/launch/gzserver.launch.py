"""Starts the simulator of Gazebo classic, which is MuJoCo here."""

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

# Those that the simulator follows, and those that files pass on to Gazebo: name → default.
FOLLOWED = {
    "world": ("", "A world; one with more than a floor is not built."),
    "pause": ("false", "Whether time stands still at first."),
    "params_file": ("", "A file of parameters."),
    "extra_gazebo_args": ("", "More words for gzserver."),
    "server_required": ("false", "Whether everything ends with the simulator."),
}
IGNORED = {
    "version": "false",
    "verbose": "false",
    "lockstep": "false",
    "help": "false",
    "initial_sim_time": "",
    "physics": "",
    "play": "",
    "record": "false",
    "record_encoding": "",
    "record_path": "",
    "record_period": "",
    "record_filter": "",
    "seed": "",
    "iters": "",
    "minimal_comms": "false",
    "profile": "",
    "gdb": "false",
    "valgrind": "false",
    "init": "true",
    "factory": "true",
    "force_system": "true",
}


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the simulator, with the arguments that Gazebo would be given."""

    def value(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    pause = ["-u"] if value("pause").lower() == "true" else []
    world = [value("world")] if value("world") else []
    file = [value("params_file")] if value("params_file") else []
    ends = value("server_required").lower() == "true"
    return [
        Node(
            package="gazebo_ros",
            executable="gzserver",
            output="screen",
            arguments=[*world, *pause, *value("extra_gazebo_args").split()],
            parameters=file,
            on_exit=[Shutdown()] if ends else None,
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Return what is to be launched."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in FOLLOWED.items()
            ),
            *(
                DeclareLaunchArgument(name, default_value=default, description="Without effect.")
                for name, default in IGNORED.items()
            ),
            OpaqueFunction(function=start),
        ]
    )

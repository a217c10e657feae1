"""``teleopctl service``: one module per verb, imported when that verb runs."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "List, call and watch services.",
    {
        "list": Verb(f"{__name__}.listing:list_services", "List the services."),
        "type": Verb(f"{__name__}.listing:service_type", "Print the type of a service."),
        "find": Verb(f"{__name__}.listing:services_of_type", "List the services of a type."),
        "info": Verb(f"{__name__}.info:service_info", "Show who serves and calls a service."),
        "call": Verb(
            f"{__name__}.call:call",
            "Call a service.",
            examples=(
                "teleopctl service call /mujoco_sim/set_pause "
                'mujoco_ros2_control_msgs/srv/SetPause "{paused: true}"',
            ),
        ),
        "echo": Verb(
            f"{__name__}.echo:echo",
            "Print what a service is asked and answers.",
            examples=("teleopctl service echo /add_two_ints --flow-style",),
        ),
    },
    leaves_nothing=True,
)

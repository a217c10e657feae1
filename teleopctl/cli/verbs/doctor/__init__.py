"""``teleopctl doctor``: checks of this machine, its network and the ROS graph."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Check the setup for problems; without a verb: check.",
    {
        "check": Verb(
            f"{__name__}.check:check",
            "Check the machine, the network and the graph for faults.",
            examples=("teleopctl doctor", "teleopctl doctor --report"),
        ),
        "hello": Verb(f"{__name__}.hello:hello", "Check the connectivity to other machines."),
    },
    alone="check",
)

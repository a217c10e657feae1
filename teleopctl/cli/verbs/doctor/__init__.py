"""``teleopctl doctor``: what is wrong with this machine, its network and the graph."""

from __future__ import annotations

from teleopctl.cli.verb import Group, Verb

GROUP = Group(
    "Look for what is wrong; without a verb: check.",
    {
        "check": Verb(
            f"{__name__}.check:check",
            "Look for what is wrong with machine, network and graph.",
            examples=("teleopctl doctor", "teleopctl doctor --report"),
        ),
        "hello": Verb(f"{__name__}.hello:hello", "See which other machines can be talked to."),
    },
    alone="check",
)

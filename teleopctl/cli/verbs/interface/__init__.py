"""``teleopctl interface``: message, service and action types; one module per verb."""

from __future__ import annotations

from teleopctl.cli.verb import Group, Verb

GROUP = Group(
    "Use definitions of messages, services and actions.",
    {
        "stubs": Verb(
            f"{__name__}.stubs:stubs",
            "Write what editors and type checkers read of your own message packages.",
            examples=("teleopctl interface stubs typings",),
        )
    },
)

"""``teleopctl tf``: transforms between frames; one module per verb."""

from __future__ import annotations

from teleopctl.cli.verb import Group, Verb

GROUP = Group(
    "Watch transforms between frames.",
    {"echo": Verb(f"{__name__}.echo:echo_transform", "Print where one frame stands in another.")},
)

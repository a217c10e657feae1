"""``teleopctl tf``: transforms between frames; one module per verb."""

from __future__ import annotations

from teleopctl.cli.verb import Group, Verb

GROUP = Group(
    "Watch transforms between frames.",
    {
        "echo": Verb(f"{__name__}.echo:echo_transform", "Print where one frame stands in another."),
        "view_frames": Verb(
            f"{__name__}.view_frames:view",
            "Draw the tree of frames.",
            examples=("teleopctl tf view_frames -o frames",),
        ),
    },
)

"""``teleopctl tf``: transforms between frames; one module per verb."""

from __future__ import annotations

from teleopctl.cli.verb import Verb, VerbGroup

GROUP = VerbGroup(
    "Watch transforms between frames.",
    {
        "echo": Verb(f"{__name__}.echo:echo_transform", "Print where one frame stands in another."),
        "list": Verb(f"{__name__}.list_:list_frames", "List the frames."),
        "monitor": Verb(
            f"{__name__}.monitor:monitor", "Print how late transforms come, and from whom."
        ),
        "static": Verb(
            f"{__name__}.static:publish",
            "Publish where a frame stands once and for all.",
            negative_numbers=True,
            examples=("teleopctl tf static --z 0.5 --frame-id world --child-frame-id table",),
        ),
        "view_frames": Verb(
            f"{__name__}.view_frames:view",
            "Draw the tree of frames.",
            examples=("teleopctl tf view_frames -o frames",),
        ),
    },
)

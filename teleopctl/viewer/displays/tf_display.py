"""``TF``: the axes and names of frames."""

from __future__ import annotations

from typing import ClassVar

from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.scene.frame_buffer import MOST_FRAMES, SILENT_S


class TfDisplay(Display):
    """Every frame's axes, x red, y green, z blue, and its name."""

    rviz_class = "TF"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Show Axes", True),
        Property("Show Names", False),
        Property("Marker Scale", 1.0, low=0.01, high=100.0, hint="1 is axes of 0.2 m"),
        Property(
            "Frame Timeout",
            15.0,
            low=1.0,
            high=1e6,
            hint="Seconds until a frame that is silent while others are not loses its axes",
        ),
    )

    def started(self) -> None:
        """Show axes and names as the properties say."""
        self.stage.frames.show(
            axes=self.values.flag("Show Axes"),
            names=self.values.flag("Show Names"),
            scale=self.values.number("Marker Scale"),
            timeout_s=self.values.number("Frame Timeout"),
        )

    def stopped(self) -> None:
        """Show neither."""
        self.stage.frames.show(axes=False, names=False)

    def tick(self) -> None:
        """Say whether there is more than can be shown."""
        if not self.stage.frames.buffer.is_full:
            self.say(OK)
            return
        self.say(
            WARN,
            f"More than {MOST_FRAMES} frames: those that are silent for {SILENT_S:.0f} s are "
            "forgotten, and new ones left out until there is room",
        )

    def time_jumped_back(self) -> None:
        """Frames move by themselves."""

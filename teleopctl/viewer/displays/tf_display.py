"""``TF``: the axes and names of frames."""

from __future__ import annotations

from typing import ClassVar

from teleopctl.viewer.displays.base import Display
from teleopctl.viewer.displays.properties import Property


class TfDisplay(Display):
    """Every frame's axes, x red, y green, z blue, and its name."""

    rviz_class = "TF"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Show Axes", True),
        Property("Show Names", False),
        Property("Marker Scale", 1.0, low=0.01, high=100.0, hint="1 is axes of 0.2 m"),
    )

    def started(self) -> None:
        """Show axes and names as the properties say."""
        self.stage.frames.show(
            axes=self.values.flag("Show Axes"),
            names=self.values.flag("Show Names"),
            scale=self.values.number("Marker Scale"),
        )

    def stopped(self) -> None:
        """Show neither."""
        self.stage.frames.show(axes=False, names=False, scale=1.0)

    def time_jumped_back(self) -> None:
        """Frames move by themselves."""

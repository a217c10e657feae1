"""``TF``: the axes and names of frames."""

from __future__ import annotations

import re
from typing import Any, ClassVar, TypeGuard

from teleopctl.base.printable import printable_line
from teleopctl.tf import AHEAD_S
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.html import ago, escaped_markdown
from teleopctl.viewer.scene.frame_buffer import MOST_FRAMES, SILENT_S

# Any stands for what YAML holds.

_ONLY, _WITHOUT = "Filter (whitelist)", "Filter (blacklist)"
# RViz's switch for the frames that it has not seen yet.
_ALL = "All Enabled"
# More frames than these is no list that anybody reads.
_MOST_LISTED = 100


class TfDisplay(Display):
    """Display of all tf frames: axes and names."""

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
        Property(_ONLY, "", hint="A regular expression: only frames that it finds are shown"),
        Property(_WITHOUT, "", hint="A regular expression: frames that it finds are not shown"),
    )
    parts_title: ClassVar[str] = "Frames"

    def _prepare(self) -> None:
        self._wrong = ""
        self._only: re.Pattern[str] | None = None
        self._without: re.Pattern[str] | None = None
        self._switches = self._said_of_frames()

    def started(self) -> None:
        """Show axes, arrows and names of frames, according to the properties."""
        self._wrong = ""
        self._only, self._without = self._expression(_ONLY), self._expression(_WITHOUT)
        self.stage.frames.show(
            axes=self.values.flag("Show Axes"),
            names=self.values.flag("Show Names"),
            scale=self.values.number("Marker Scale"),
            timeout_s=self.values.number("Frame Timeout"),
            which=self._is_shown,
        )

    def stopped(self) -> None:
        """Hide axes and names."""
        self.stage.frames.show(axes=False, names=False)

    def tick(self) -> None:
        """Set the status: frames beyond the limit, and frames that are left out."""
        faults = [self._wrong] if self._wrong else []
        if self.stage.frames.buffer.is_full:
            faults.append(
                f"More than {MOST_FRAMES} frames: those that are silent for {SILENT_S:.0f} s are "
                "forgotten, and new ones left out until there is room"
            )
        if left_out := self._left_out():
            faults.append(left_out)
        self.say(WARN if faults else OK, ". ".join(faults))

    def _left_out(self) -> str:
        """Return what the buffer left out since the last reset, and who published it."""
        counts = sorted(self.stage.frames.buffer.left_out.items())
        if not counts:
            return ""
        listed = ", ".join(f"{count} of {printable_line(name)}" for name, count in counts)
        return (
            f"Transforms more than {AHEAD_S:.0f} s ahead of /clock are left out: {listed}; "
            "a node here is not on simulated time"
        )

    def parts(self) -> dict[str, bool]:
        """Return the frames, with their visibility."""
        return {
            name: self._is_on(name) for name in sorted(self.stage.frames.by_name)[:_MOST_LISTED]
        }

    def parts_text(self) -> str:
        """Return a Markdown table of frames: parent, age, and which are left out."""
        ages = sorted(self.stage.frames.buffer.ages().items())[:_MOST_LISTED]
        rows = [
            f"| {escaped_markdown(name)} | {escaped_markdown(parent)} "
            f"| {'static' if age_s is None else ago(age_s)} |"
            for name, (parent, age_s) in ages
        ]
        text = "\n".join(["| frame | in | heard |", "|---|---|---|", *rows]) if rows else ""
        left_out = escaped_markdown(self._left_out())
        return "\n\n".join(filter(None, (left_out, text)))

    def show_part(self, name: str, *, shown: bool) -> None:
        """Show or hide a frame."""
        given = self.values.given
        if not _is_mapping(given.get("Frames")):
            given["Frames"] = {}
        frames = given["Frames"]
        frames[next((one for one in frames if str(one) == name), name)] = {"Value": shown}
        self._switches = self._said_of_frames()
        if self.is_drawn:
            self.started()

    def _said_of_frames(self) -> dict[str, Any]:
        """What the file says of frames, by name; names may look like numbers."""
        said = self.values.given.get("Frames")
        return {str(name): one for name, one in said.items()} if _is_mapping(said) else {}

    def _is_on(self, name: str) -> bool:
        said = self._switches.get(name)
        if _is_mapping(said) and said.get("Value") is not None:
            return said["Value"] is not False
        return self._switches.get(_ALL) is not False

    def _is_shown(self, name: str) -> bool:
        return (
            (self._only is None or self._only.search(name) is not None)
            and (self._without is None or self._without.search(name) is None)
            and self._is_on(name)
        )

    def _expression(self, name: str) -> re.Pattern[str] | None:
        """A property that is a regular expression; None for an empty one, or one that is wrong."""
        text = self.values.text(name)
        try:
            return re.compile(text) if text else None
        except re.error as error:
            self._wrong = f"{name} is no regular expression: {error}"
            return None

    def time_jumped_back(self) -> None:
        """Do nothing: tf moves the frames."""


def _is_mapping(value: Any) -> TypeGuard[dict[Any, Any]]:
    return isinstance(value, dict)

"""Displays of tf frames: ``TF``, ``Axes``, ``Grid`` and ``Trace``."""

from __future__ import annotations

import re
from collections import deque
from typing import Any, ClassVar, Literal, TypeGuard

import numpy as np

from teleopctl.base.printable import printable_line
from teleopctl.tf import AHEAD_S, Transform, TransformException
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.conversions import rgba_of
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.html import age_text, escaped_markdown
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing
from teleopctl.viewer.scene.frames import MOST_FRAMES, SILENT_S

# Any: YAML values.

_ONLY, _WITHOUT = "Filter (whitelist)", "Filter (blacklist)"
# RViz's switch for frames without a switch of their own.
_ALL = "All Enabled"
# A longer list is not readable.
_MOST_LISTED = 100


class TfDisplay(Display):
    """RViz's ``TF`` display: axes and names of tf frames, filtered by name."""

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
            hint="Seconds without updates after which a frame's axes are removed",
        ),
        Property(_ONLY, "", hint="A regular expression: only frames that it finds are shown"),
        Property(_WITHOUT, "", hint="A regular expression: frames that it finds are not shown"),
    )
    parts_title: ClassVar[str] = "Frames"

    def _prepare(self) -> None:
        self._wrong = ""
        self._only: re.Pattern[str] | None = None
        self._without: re.Pattern[str] | None = None
        self._switches = self._frame_switches()

    def started(self) -> None:
        """Show axes and names of tf frames by the properties; called when the display starts."""
        self._wrong = ""
        self._only, self._without = self._expression(_ONLY), self._expression(_WITHOUT)
        self.stage.frames.set_appearance(
            axes=self.values.flag("Show Axes"),
            names=self.values.flag("Show Names"),
            scale=self.values.number("Marker Scale"),
            timeout_s=self.values.number("Frame Timeout"),
            which=self._is_shown,
        )

    def stopped(self) -> None:
        """Hide axes and names of all tf frames; called when the display stops."""
        self.stage.frames.set_appearance(axes=False, names=False)

    def tick(self) -> None:
        """Set the status: OK, or a warning on too many frames, rejected transforms or a filter."""
        faults = [self._wrong] if self._wrong else []
        if self.stage.frames.buffer.is_full:
            faults.append(
                f"More than {MOST_FRAMES} frames: those without messages for {SILENT_S:.0f} s are "
                "forgotten, and new ones left out until there is room"
            )
        if left_out := self._left_out():
            faults.append(left_out)
        self.set_status(WARN if faults else OK, ". ".join(faults))

    def _left_out(self) -> str:
        """Return a sentence about the transforms rejected since the last reset, by publisher."""
        counts = sorted(self.stage.frames.buffer.left_out.items())
        if not counts:
            return ""
        listed = ", ".join(f"{count} of {printable_line(name)}" for name, count in counts)
        return (
            f"Transforms more than {AHEAD_S:.0f} s ahead of /clock are left out: {listed}; "
            "a node does not use simulated time"
        )

    def parts(self) -> dict[str, bool]:
        """Return whether each of the first 100 tf frames is shown, by name; see `Display.parts`."""
        return {
            name: self._is_on(name) for name in sorted(self.stage.frames.by_name)[:_MOST_LISTED]
        }

    def parts_text(self) -> str:
        """Return Markdown: rejected transforms, and a table of tf frames with parent and age."""
        ages = sorted(self.stage.frames.buffer.ages().items())[:_MOST_LISTED]
        rows = [
            f"| {escaped_markdown(name)} | {escaped_markdown(parent)} "
            f"| {'static' if age_s is None else age_text(age_s)} |"
            for name, (parent, age_s) in ages
        ]
        text = "\n".join(["| frame | parent | received |", "|---|---|---|", *rows]) if rows else ""
        left_out = escaped_markdown(self._left_out())
        return "\n\n".join(filter(None, (left_out, text)))

    def show_part(self, name: str, *, shown: bool) -> None:
        """Show or hide a tf frame, and store that in the ``.rviz`` mapping."""
        given = self.values.given
        if not _is_mapping(given.get("Frames")):
            given["Frames"] = {}
        frames = given["Frames"]
        frames[next((one for one in frames if str(one) == name), name)] = {"Value": shown}
        self._switches = self._frame_switches()
        if self.is_drawn:
            self.started()

    def _frame_switches(self) -> dict[str, Any]:
        """Return the file's mapping of frames; YAML may have read names as numbers."""
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
            self._wrong = f"{name} is not a regular expression: {error}"
            return None

    def time_jumped_back(self) -> None:
        """Do nothing when ROS time jumps back, since tf moves the frames."""


def _is_mapping(value: Any) -> TypeGuard[dict[Any, Any]]:
    return isinstance(value, dict)


# Any: messages, whose classes are created from definitions at run time.

_FIXED_FRAME = "<Fixed Frame>"


class Axes(Display):
    """RViz's ``Axes`` display: the axes of one frame; x red, y green, z blue."""

    rviz_class = "Axes"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Reference Frame", _FIXED_FRAME, is_frame=True),
        Property("Length", 1.0, low=0.001, high=1000.0),
        Property("Radius", 0.1, low=0.001, high=1000.0),
        Property("Alpha", 1.0, low=0.0, high=1.0),
    )

    def _prepare(self) -> None:
        self._canvas: Canvas | None = None

    def started(self) -> None:
        """Draw the axes at the reference frame's scene node; called when the display starts."""
        frame = self.values.text("Reference Frame")
        above = "" if frame == _FIXED_FRAME else self.stage.frames.node_path(frame)
        drawing = Drawing()
        length, radius = self.values.number("Length"), self.values.number("Radius")
        drawing.axes(Transform(), length, radius, self.values.number("Alpha"))
        self._canvas = Canvas(self.stage.scene, f"{above}{self.root}")
        self._canvas.show(drawing)

    def tick(self) -> None:
        """Set the status to OK, or to a warning while the reference frame has no transform."""
        name = self.values.text("Reference Frame").removeprefix("/")
        frame = self.stage.frames.by_name.get(name)
        known = name == _FIXED_FRAME or (frame is not None and frame.pose is not None)
        fixed = self.stage.frames.fixed
        self.set_status(OK) if known else self.set_status(
            WARN, f"No transform from [{name}] to [{fixed}]"
        )

    def stopped(self) -> None:
        """Remove the axes from the scene; called when the display stops."""
        if self._canvas is not None:
            self._canvas.remove()
            self._canvas = None

    def time_jumped_back(self) -> None:
        """Do nothing when ROS time jumps back, since tf moves the reference frame."""


_PLANES: dict[str, Literal["xy", "xz", "yz"]] = {"XY": "xy", "XZ": "xz", "YZ": "yz"}


class Grid(Display):
    """RViz's ``Grid`` display: a square grid around the origin of a frame."""

    rviz_class = "Grid"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Reference Frame", _FIXED_FRAME),
        Property("Plane", "XY", choices=("XY", "XZ", "YZ")),
        Property("Plane Cell Count", 10, low=1, high=1000),
        Property("Cell Size", 1.0, low=0.001, high=1000.0, hint="Metres"),
        Property("Color", (160, 160, 164)),
        Property("Alpha", 0.5, low=0.0, high=1.0),
    )

    def _prepare(self) -> None:
        self._node: Any = None

    def started(self) -> None:
        """Draw the grid's lines at the reference frame; called when the display starts."""
        frame = self.values.text("Reference Frame")
        above = "" if frame == _FIXED_FRAME else self.stage.frames.node_path(frame)
        cell = self.values.number("Cell Size")
        size = cell * int(self.values.number("Plane Cell Count"))
        color = self.values.color("Color")
        self._node = self.stage.scene.add_grid(
            f"{above}{self.root}",
            size,
            size,
            plane=_PLANES[self.values.text("Plane")],
            cell_size=cell,
            section_size=cell,
            cell_color=color,
            section_color=color,
            fade_distance=max(100.0, 3 * size),
        )

    def stopped(self) -> None:
        """Remove the grid from the scene; called when the display stops."""
        if self._node is not None:
            self._node.remove()
            self._node = None

    def time_jumped_back(self) -> None:
        """Do nothing when ROS time jumps back, since a grid has no stamp."""


MOST_POINTS = 2000
_NANOSECONDS = 1e9
# The line is redrawn at every third of 30 updates a second.
_PICTURES_PER_DRAWING = 3
# A smaller movement adds no point.
_LEAST_STEP_M = 0.0005
# A new number of points replaces the scene node, so the number grows in steps of this size.
_POINTS_AT_ONCE = 64


class Trace(Display):
    """Display of the path of a frame's origin in the fixed frame, over the last seconds.

    RViz has no equivalent. Seconds are those of the node's clock, so the line stays while a
    simulation is paused.
    """

    rviz_class = "Trace"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Frame", "", is_frame=True, hint="The frame whose path is drawn"),
        Property("Seconds", 10.0, low=0.1, high=3600.0, hint="How far back"),
        Property("Color", (255, 170, 0)),
        Property("Line Width", 0.004, low=0.0, high=10.0, hint="Metres; 0 for the thinnest line"),
    )

    def _prepare(self) -> None:
        self._points: deque[tuple[float, tuple[float, float, float]]] = deque(maxlen=MOST_POINTS)
        self._fixed = ""
        self._pictures = 0
        self._is_new = False
        self._canvas: Canvas | None = None

    def started(self) -> None:
        """Create the trace's canvas; a line appears once there are two points."""
        self._canvas = Canvas(self.stage.scene, self.root)
        self._is_new = True

    def stopped(self) -> None:
        """Remove the line from the scene, and clear its points; called when the display stops."""
        self._points.clear()
        self._remove()

    def changed(self, name: str) -> None:
        """Redraw the trace; clear its points first if the property ``Frame`` was set."""
        if name == "Frame":
            self._points.clear()
        self._remove()
        self.started()

    def tick(self) -> None:
        """Add the frame's fixed-frame position if it moved; redraw at most ten times a second."""
        name, fixed = self.values.text("Frame").removeprefix("/"), self.stage.frames.fixed
        if fixed != self._fixed:
            # Positions in the former fixed frame are not valid in the new one.
            self._fixed = fixed
            self.stopped()
            self.started()
        if not name:
            self.set_status(OK, "Choose a frame")
            return
        try:
            place = self.stage.frames.pose_in_fixed_frame(name).translation
        except TransformException:
            self.set_status(WARN, f"No transform from [{name}] to [{fixed}]")
            return
        self.set_status(OK)
        now_s = self.stage.node.get_clock().now().nanoseconds / _NANOSECONDS
        self._add_point(now_s, place)
        self._pictures += 1
        if self._is_new and self._pictures % _PICTURES_PER_DRAWING == 0:
            self._is_new = False
            self._draw()

    def _add_point(self, now_s: float, place: tuple[float, float, float]) -> None:
        seconds = self.values.number("Seconds")
        points = self._points
        while points and points[0][0] < now_s - seconds:
            points.popleft()
            self._is_new = True
        if points:
            last_s, last = points[-1]
            step = max(abs(one - other) for one, other in zip(place, last, strict=True))
            if step < _LEAST_STEP_M or now_s - last_s < seconds / MOST_POINTS:
                return
        points.append((now_s, place))
        self._is_new = True

    def _draw(self) -> None:
        assert self._canvas is not None
        drawing = Drawing()
        if len(self._points) > 1:
            places = np.array([place for _, place in self._points])
            missing = -len(places) % _POINTS_AT_ONCE
            places = np.vstack([places, np.repeat(places[-1:], missing, axis=0)])
            color = np.array(rgba_of(self.values.color("Color")))
            drawing.line(places, color, self.values.number("Line Width"), strip=True)
        self._canvas.show(drawing)

    def _remove(self) -> None:
        if self._canvas is not None:
            self._canvas.remove()
            self._canvas = None

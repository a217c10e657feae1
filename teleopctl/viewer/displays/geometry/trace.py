"""``Trace``: the way that a frame has gone in the last seconds."""

from __future__ import annotations

from collections import deque
from typing import ClassVar

import numpy as np

from teleopctl.tf import TransformException
from teleopctl.viewer.displays.base import OK, WARN, Display
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import rgba_of
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing

# Any stands for what a display is made with.

MOST_POINTS = 2000
_NANOSECONDS = 1e9
# Of thirty pictures a second: a line need not grow in each of them.
_PICTURES_PER_DRAWING = 3
# What moves less stands still.
_LEAST_STEP_M = 0.0005
# A line of another length is another node of the scene: so it grows by many points at once.
_POINTS_AT_ONCE = 64


class Trace(Display):
    """Display of a frame's path in the fixed frame.

    RViz has no such display. Its time is the node's, so that the line of a paused simulation stays.
    """

    rviz_class = "Trace"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Frame", "", is_frame=True, hint="Whose way is drawn"),
        Property("Seconds", 10.0, low=0.1, high=3600.0, hint="How far back"),
        Property("Color", (255, 170, 0)),
        Property("Line Width", 0.004, low=0.0, high=10.0, hint="Metres; 0 is as thin as can be"),
    )

    def _prepare(self) -> None:
        self._points: deque[tuple[float, tuple[float, float, float]]] = deque(maxlen=MOST_POINTS)
        self._fixed = ""
        self._pictures = 0
        self._is_new = False
        self._canvas: Canvas | None = None

    def started(self) -> None:
        """Start a new line, which is drawn from two points on."""
        self._canvas = Canvas(self.stage.scene, self.root)
        self._is_new = True

    def stopped(self) -> None:
        """Remove the line from the scene and clear its points."""
        self._points.clear()
        self._remove()

    def changed(self, name: str) -> None:
        """Redraw; if the frame was changed, clear the points first."""
        if name == "Frame":
            self._points.clear()
        self._remove()
        self.started()

    def tick(self) -> None:
        """Add the frame's present position to the line."""
        name, fixed = self.values.text("Frame").removeprefix("/"), self.stage.frames.fixed
        if fixed != self._fixed:
            # Where the frame was in the other fixed frame says nothing here.
            self._fixed = fixed
            self.stopped()
            self.started()
        if not name:
            self.say(OK, "Choose a frame")
            return
        try:
            place = self.stage.frames.pose_in_fixed(name).translation
        except TransformException:
            self.say(WARN, f"No transform from [{name}] to [{fixed}]")
            return
        self.say(OK)
        now_s = self.stage.node.get_clock().now().nanoseconds / _NANOSECONDS
        self._note(now_s, place)
        self._pictures += 1
        if self._is_new and self._pictures % _PICTURES_PER_DRAWING == 0:
            self._is_new = False
            self._draw()

    def _note(self, now_s: float, place: tuple[float, float, float]) -> None:
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

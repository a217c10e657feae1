"""Displays whose messages become drawings of solids and lines."""

from __future__ import annotations

from collections import deque
from typing import Any

from teleopctl.tf import Transform
from teleopctl.viewer.displays.stamped import StampedDisplay
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import Drawing, merged

# Any stands for messages throughout: their classes are made at run time, from definitions.


class DrawnDisplay(StampedDisplay):
    """Base of displays that draw each message by `drawing`."""

    def _prepare(self) -> None:
        super()._prepare()
        self.canvas = Canvas(self.stage.scene, self.root)
        self._drawings: deque[Drawing] = deque()
        self._stale = False

    def drawing(self, message: Any) -> Drawing:
        """Return the drawing of a message, in the frame of its header."""
        raise NotImplementedError

    def placed(self, message: Any, pose: Transform) -> None:
        """Add a message's drawing, and drop the oldest beyond the limit."""
        self._drawings.append(self.drawing(message).moved(pose))
        while len(self._drawings) > self.keeps:
            self._drawings.popleft()
        self._stale = True

    def tick(self) -> None:
        """Send changed drawings to the scene."""
        super().tick()
        if self._stale:
            self._stale = False
            self.canvas.show(self.whole())

    def whole(self) -> Drawing:
        """Return the drawing of all messages, in the fixed frame."""
        return merged(self._drawings)

    def emptied(self) -> None:
        """Clear all drawings."""
        self._drawings.clear()
        self._stale = True
        if not self.is_drawn:
            self._stale = False
            self.canvas.remove()

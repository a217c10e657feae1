"""What the page knows of frames: so many, however many names somebody makes up."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING

from teleopctl.tf import LiveBuffer

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

    from teleopctl.node import Node

MOST_FRAMES = 1000
"""Far more than any robot has; to follow so many takes a fifth of a core."""

SILENT_S = 15.0
"""After how long without news a frame may be forgotten, to make room for others."""

# When there is no room, all are looked through, and more than one is forgotten.
_LOOKS_EVERY_S = 1.0
_SHARE_FORGOTTEN = 0.1
# For how long it is told.
_TOLD_S = 10.0


class FrameBuffer(LiveBuffer):
    """tf buffer with a limited number of frames.

    tf2 never forgets a frame. A program that names each thing that it sees anew would fill the
    memory of the page, and of every browser.

    When there are too many, those that have been silent for longest are forgotten, but for static
    ones and those in which others stand. Where none is silent, new ones are left out: what is in
    the picture stays there.

    Args:
        node: See `LiveBuffer`.
    """

    def __init__(self, node: Node | None = None) -> None:
        super().__init__(node=node)
        # When each frame was heard of last; for ever where it is static.
        self._heard: dict[str, float] = {}
        self._looked_s = self._full_s = -math.inf

    @property
    def is_full(self) -> bool:
        """Whether frames were dropped or left out recently."""
        return time.monotonic() - self._full_s < _TOLD_S

    def silent(self, longer_than_s: float) -> set[str]:
        """Return the moving frames without recent transforms, while others have them.

        Nobody counts as silent where all are: a simulation that is paused, a bag that has ended.

        Args:
            longer_than_s: For how long.
        """
        with self._changed:
            moving = {name: at_s for name, at_s in self._heard.items() if at_s < math.inf}
        since_s = max(moving.values(), default=0.0) - longer_than_s
        return {name for name, at_s in moving.items() if at_s < since_s}

    def ages(self) -> dict[str, tuple[str, float | None]]:
        """Return each frame's parent and age in seconds; the age is None for static frames."""
        now_s = time.monotonic()
        parents = {name: sample.parent for name, sample in self.latest()}
        with self._changed:
            heard = dict(self._heard)
        return {
            name: (parent, None if math.isinf(at_s) else now_s - at_s)
            for name, parent in parents.items()
            if (at_s := heard.get(name)) is not None
        }

    def clear(self) -> None:
        """Drop all moving frames."""
        with self._changed:
            super().clear()
            self._heard = {name: at_s for name, at_s in self._heard.items() if math.isinf(at_s)}

    def forget(self, frames: Iterable[str]) -> None:
        """Drop frames, with all names that are then unused."""
        names = tuple(frames)
        with self._changed:
            super().forget(names)
            for name in names:
                self._heard.pop(name, None)

    def _admits(self, message: TransformStamped, authority: str, *, static: bool) -> bool:
        name, now_s = message.child_frame_id.removeprefix("/"), time.monotonic()
        if name not in self._heard and not self._has_room(now_s):
            return False
        if not super()._admits(message, authority, static=static):
            return False
        self._heard[name] = math.inf if static else now_s
        if len(self._tree) > 2 * MOST_FRAMES:
            # Each may have a parent of its own. The others are parents of former times.
            self.forget(())
        return True

    def _has_room(self, now_s: float) -> bool:
        if len(self._heard) < MOST_FRAMES:
            return True
        self._full_s = now_s
        if now_s - self._looked_s >= _LOOKS_EVERY_S:
            self._looked_s = now_s
            self._make_room(now_s)
        return len(self._heard) < MOST_FRAMES

    def _make_room(self, now_s: float) -> None:
        parents = {name: sample.parent for name, sample in self.latest()}
        silent = {name for name, at_s in self._heard.items() if now_s - at_s > SILENT_S}
        for name in self._heard.keys() - silent:
            above = parents.get(name, "")
            while above in silent:
                silent.remove(above)
                above = parents.get(above, "")
        oldest_first = sorted(silent, key=self._heard.__getitem__)
        gone = oldest_first[: math.ceil(MOST_FRAMES * _SHARE_FORGOTTEN)]
        self.forget(gone)

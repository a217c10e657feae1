"""Buffer for displays of present transforms, robust against one node with a wrong clock.

tf2 compares stamps with the newest stamp of a frame: after one transform with a wall-time stamp in
a tree of simulated stamps, every later one is too old (``TF_OLD_DATA``) until the buffer is
cleared. Programs may rely on that, and may hold predictions of the far future, so `Buffer` behaves
as tf2, and a separate class holds these rules. They are in the buffer rather than in the listener
because they also apply to transforms that the tree already holds.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING

from teleopctl.base.printable import printable_line
from teleopctl.interfaces import to_seconds
from teleopctl.node import ROSClock
from teleopctl.tf.buffer import Buffer
from teleopctl.tf.messages import TimeLike, stamp_of

if TYPE_CHECKING:
    from geometry_msgs.msg import TransformStamped

    from teleopctl.node import Node

_log = logging.getLogger(__name__)

AHEAD_S = 60.0
"""Longest time that a moving transform may lie ahead of simulated time, in seconds.

Localization publishes up to some seconds ahead (amcl's ``transform_tolerance`` is 1 s), and
``/clock`` may lag behind a simulation that runs as fast as it can; wall time is decades ahead.
"""

STALE_S = 1.0
"""Time without a newer stamp after which older stamps are accepted, in seconds of wall time.

Moving frames are published more often than this, so the source of the newer stamps has ended.
"""

_AHEAD_NS = int(AHEAD_S * 1e9)


class LiveBuffer(Buffer):
    """`Buffer` that drops moving transforms more than 60 s ahead of ``/clock``, if simulated.

    If the node uses simulated time, moving transforms more than `AHEAD_S` ahead of ``/clock`` are
    dropped and counted; static transforms are never dropped. Transforms received before the first
    message of ``/clock`` are checked when that message arrives.

    If a frame received no newer stamp for `STALE_S` but still receives older ones, the older stamps
    are those of the current clock: the history of the frame is dropped, and starts again with them.
    This happens after a node on another clock has ended, and after a late transform of the former
    run arrived when simulated time had jumped back.

    Args:
        cache_time: See `Buffer`.
        node: See `Buffer`; without a node, there is no clock to compare with.

    Attributes:
        left_out: Number of dropped transforms by the name of their publisher.
    """

    def __init__(self, cache_time: TimeLike | None = None, node: Node | None = None) -> None:
        super().__init__(cache_time, node)
        self.left_out: dict[str, int] = {}
        # Newest stamp of each moving frame, and its arrival in seconds of the steady clock.
        self._newest: dict[str, tuple[int, float]] = {}
        self._has_time = False

    def clear(self) -> None:
        """Drop the transforms of moving frames, and the counts of transforms dropped before."""
        with self._changed:
            super().clear()
            self._newest.clear()
            self.left_out.clear()

    def forget(self, frames: Iterable[str]) -> None:
        """Remove these frames' transforms, and names that are then no parent either."""
        names = tuple(frames)
        with self._changed:
            super().forget(names)
            for name in names:
                self._newest.pop(name, None)

    def _set(self, message: TransformStamped, authority: str, *, static: bool) -> None:
        with self._changed:
            is_admitted = self._admits(message, authority, static=static)
        # Outside the lock: this may complete futures that wait for the transform.
        if is_admitted:
            super()._set(message, authority, static=static)

    def _admits(self, message: TransformStamped, authority: str, *, static: bool) -> bool:
        """Return whether to add a transform; drops the frame's history if it is stale."""
        name = message.child_frame_id.removeprefix("/")
        if static:
            self._newest.pop(name, None)
            return True
        stamp = stamp_of(message.header.stamp)
        if self._is_ahead(stamp, name, authority):
            return False
        now_s = time.monotonic()
        newest, came_s = self._newest.get(name, (stamp, now_s))
        if stamp < newest and now_s - came_s > STALE_S:
            self.forget([name])
            newest = stamp
        if stamp >= newest:
            self._newest[name] = (stamp, now_s)
        return True

    def _is_ahead(self, stamp: int, name: str, authority: str) -> bool:
        clock = None if self.node is None else self.node.get_clock()
        if not isinstance(clock, ROSClock) or not clock.ros_time_is_active:
            self._has_time = False
            return False
        now = clock.nanoseconds()
        if not self._has_time:
            # The clock is at 0 before the first message of /clock.
            if now == 0:
                return False
            self._has_time = True
            self._leave_out_afterwards(now + _AHEAD_NS)
        if stamp <= now + _AHEAD_NS:
            return False
        self._count(authority, name, stamp - now)
        return True

    def _leave_out_afterwards(self, latest: int) -> None:
        """Drop and count frames newer than a stamp, added before the first ``/clock`` message."""
        ahead = {name: stamp for name, (stamp, _) in self._newest.items() if stamp > latest}
        for name, stamp in ahead.items():
            self._count(self._tree.authority(name), name, stamp - latest + _AHEAD_NS)
        self.forget(ahead)

    def _count(self, authority: str, name: str, ahead: int) -> None:
        if authority not in self.left_out:
            _log.warning(
                "Left out transforms of %s, such as that of frame %s: their stamps are %.0f s "
                "ahead of /clock. A node uses wall time beside the simulation: stop "
                "it, or start it with use_sim_time:=true",
                printable_line(authority),
                printable_line(name),
                to_seconds(ahead),
            )
        self.left_out[authority] = self.left_out.get(authority, 0) + 1

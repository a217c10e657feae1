"""``/clock`` while a bag is played: its time line, for nodes with ``use_sim_time``."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from teleopctl.bag.player.options import PlayOptions
from teleopctl.bag.player.time_line import TimeLine
from teleopctl.interfaces import get_message
from teleopctl.node import QoSProfile, ReliabilityPolicy, Time

if TYPE_CHECKING:
    from teleopctl.node import Node

CLOCK = "/clock"
_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class ClockOutput:
    """Publishes the playback time on /clock, at a rate or with messages of given topics.

    Args:
        node: The node that publishes.
        line: What time it is.
        options: When it is published.
    """

    def __init__(self, node: Node, line: TimeLine, options: PlayOptions) -> None:
        self._node = node
        self._line = line
        self._topics = None if options.clock_topics is None else frozenset(options.clock_topics)
        self._class = get_message("rosgraph_msgs/msg/Clock")
        self._publisher = None
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None
        if options.clock_hz is None and self._topics == frozenset():
            return
        self._publisher = node.create_publisher(self._class, CLOCK, _QOS)
        if options.clock_hz is not None:
            self._thread = threading.Thread(
                target=self._tick, args=(1 / options.clock_hz,), name="bag-clock", daemon=True
            )

    def start(self) -> None:
        """Start publishing at the rate. Idempotent."""
        if self._thread is not None and self._thread.ident is None:
            self._thread.start()

    def before(self, topic: str) -> None:
        """Publish the time if messages of this topic are to come with it."""
        if self._topics is None or topic in self._topics:
            self.publish()

    def publish(self) -> None:
        """Publish the time, if /clock was requested."""
        if self._publisher is not None:
            stamp = Time(nanoseconds=self._line.now_ns()).to_msg()
            self._publisher.publish(self._class(clock=stamp))

    def close(self) -> None:
        """Stop the thread, and destroy the publisher."""
        self._ending.set()
        if self._thread is not None and self._thread.ident is not None:
            self._thread.join()
        if self._publisher is not None:
            self._node.destroy_publisher(self._publisher)

    def _tick(self, period_s: float) -> None:
        due_s = time.monotonic()
        while not self._ending.wait(max(0.0, due_s - time.monotonic())):
            try:
                self.publish()
            except Exception:  # noqa: BLE001 (the session has ended)
                return
            due_s += period_s

"""Playback time, which runs at a rate, pauses and jumps, and its publication on ``/clock``."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Protocol

from teleopctl.bag.player.options import PlayOptions
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_message
from teleopctl.node import QoSProfile, ReliabilityPolicy, Time

if TYPE_CHECKING:
    from teleopctl.node import Node


class SteadyClock(Protocol):
    """Interface of the steady clock behind playback time; tests provide their own."""

    def now_ns(self) -> int:
        """Return the steady time in nanoseconds, from any origin."""

    def wait(self, changed: threading.Condition, longest_ns: int | None) -> None:
        """Wait on a condition until it is notified or the time limit is over.

        Args:
            changed: Condition to wait on, which the caller holds.
            longest_ns: Longest wait in nanoseconds; None for no limit.
        """


class _ProcessTime:
    """The steady clock of the operating system."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait(self, changed: threading.Condition, longest_ns: int | None) -> None:
        changed.wait(None if longest_ns is None else longest_ns / NANOSECONDS_PER_SECOND)


class PlaybackTime:
    """Clock of a player, in the bag's time: runs at a rate, can be paused, and can jump.

    One thread waits in `wait_until`; any thread may change the clock, which ends the wait.

    Args:
        start_ns: First playback time, in nanoseconds since the epoch.
        rate: Seconds of playback time per second of the steady clock.
        is_paused: Whether the clock starts paused.
        steady: Steady clock that drives the playback time; None for that of the system.
    """

    def __init__(
        self,
        start_ns: int = 0,
        rate: float = 1.0,
        *,
        is_paused: bool = False,
        steady: SteadyClock | None = None,
    ) -> None:
        self._steady = steady or _ProcessTime()
        self._changed = threading.Condition()
        self._rate = rate
        self._is_paused = is_paused
        # Steady time of the last change, and the playback time then.
        self._anchor_ns = self._steady.now_ns()
        self._time_ns = start_ns
        self._is_woken = False

    @property
    def rate(self) -> float:
        """Seconds of playback time for each second of the steady clock."""
        return self._rate

    @property
    def is_paused(self) -> bool:
        """Whether the playback time is paused."""
        return self._is_paused

    def now_ns(self) -> int:
        """Return the playback time, in nanoseconds since the epoch."""
        with self._changed:
            return self._now_ns()

    def pause(self) -> None:
        """Pause the playback time; idempotent."""
        with self._changed:
            self._set(self._now_ns())
            self._is_paused = True

    def resume(self) -> None:
        """Resume the playback time; idempotent."""
        with self._changed:
            self._set(self._now_ns())
            self._is_paused = False

    def set_rate(self, rate: float) -> bool:
        """Set the rate of the playback time; return False for a rate of 0 or less."""
        if not 0 < rate < float("inf"):
            return False
        with self._changed:
            self._set(self._now_ns())
            self._rate = rate
        return True

    def jump(self, time_ns: int) -> None:
        """Set the playback time, in nanoseconds since the epoch, and end a running `wait_until`."""
        with self._changed:
            self._set(time_ns)

    def wake(self) -> None:
        """End the running `wait_until` early, or the next one if no thread waits."""
        with self._changed:
            self._is_woken = True
            self._changed.notify_all()

    def wait_until(self, time_ns: int | None) -> bool:
        """Wait until the playback time reaches a time; return False if changed or woken before.

        Args:
            time_ns: Playback time in nanoseconds since the epoch; None waits for a change.

        Returns:
            True when the time is reached; False if the clock was changed or `wake` was called, so
            that the caller must check its state again.
        """
        with self._changed:
            while not self._is_woken:
                longest_ns = None
                if time_ns is not None and not self._is_paused:
                    longest_ns = self._steady_ns(time_ns) - self._steady.now_ns()
                    if longest_ns <= 0:
                        return True
                self._steady.wait(self._changed, longest_ns)
            self._is_woken = False
            return False

    def _now_ns(self) -> int:
        if self._is_paused:
            return self._time_ns
        return self._time_ns + int((self._steady.now_ns() - self._anchor_ns) * self._rate)

    def _steady_ns(self, time_ns: int) -> int:
        """Return the steady time at which a playback time is reached, in nanoseconds."""
        return self._anchor_ns + int((time_ns - self._time_ns) / self._rate)

    def _set(self, time_ns: int) -> None:
        self._anchor_ns = self._steady.now_ns()
        self._time_ns = time_ns
        self._is_woken = True
        self._changed.notify_all()


CLOCK = "/clock"
_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class PlaybackClock:
    """Publisher of the playback time on /clock, at a rate or before messages of given topics.

    Args:
        node: Node of the publisher.
        playback_time: Playback time to publish.
        options: Options with rate and topics of the publication.
    """

    def __init__(self, node: Node, playback_time: PlaybackTime, options: PlayOptions) -> None:
        self._node = node
        self._playback_time = playback_time
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
        """Start the thread that publishes /clock at a rate, if one was requested; idempotent."""
        if self._thread is not None and self._thread.ident is None:
            self._thread.start()

    def publish_before(self, topic: str) -> None:
        """Publish /clock before a message of a topic, if requested for this topic."""
        if self._topics is None or topic in self._topics:
            self.publish()

    def publish(self) -> None:
        """Publish the playback time on /clock, if any /clock publication was requested."""
        if self._publisher is not None:
            stamp = Time(nanoseconds=self._playback_time.now_ns()).to_msg()
            self._publisher.publish(self._class(clock=stamp))

    def close(self) -> None:
        """Stop the publishing thread, and destroy the /clock publisher."""
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

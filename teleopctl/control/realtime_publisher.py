"""Messages on their way out of the control loop.

Controllers offer plain values; the message is built and published elsewhere. On the wall clock a
thread of its own does it and only the latest value of each channel counts, so that a slow network
never slows the loop. In lockstep the loop itself publishes, after it has answered the simulator:
every value, in the order in which it was offered.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any


class Channel:
    """One outlet of the control loop.

    Args:
        outbox: Where it belongs.
        publish: Called outside the control cycle with the value that was offered.
    """

    __slots__ = ("_outbox", "publish")

    def __init__(self, outbox: Outbox, publish: Callable[[Any], None]) -> None:
        self._outbox = outbox
        self.publish = publish

    def offer(self, value: object) -> None:
        """Hand a value over; it must not be changed afterwards."""
        self._outbox.put(self, value)


class Outbox:
    """Collects what the control loop offers and publishes it.

    Args:
        report: Called with a sentence when publishing fails.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        self._report = report
        self._queue: deque[tuple[Channel, object]] = deque()
        self._latest: dict[Channel, object] = {}
        self._wake = threading.Event()
        self._thread: threading.Thread | None = None
        self._stopping = False

    def channel(self, publish: Callable[[Any], None]) -> Channel:
        """A new outlet.

        Args:
            publish: Builds and sends the message for a value.
        """
        return Channel(self, publish)

    def start_thread(self) -> None:
        """Publish from a thread of its own from now on, the latest value of each channel."""
        self._thread = threading.Thread(target=self._run, name="outbox", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the thread."""
        self._stopping = True
        self._wake.set()
        if self._thread is not None:
            self._thread.join(timeout=1.0)
            self._thread = None

    def put(self, channel: Channel, value: object) -> None:
        """Take a value from a channel."""
        if self._thread is None:
            self._queue.append((channel, value))
        else:
            self._latest[channel] = value

    def flush(self) -> None:
        """End of a cycle: publish now, or wake the thread that does."""
        if self._thread is not None:
            if self._latest:
                self._wake.set()
            return
        while self._queue:
            channel, value = self._queue.popleft()
            self._send(channel, value)

    def _run(self) -> None:
        while not self._stopping:
            self._wake.wait()
            self._wake.clear()
            # A copy of the keys in one step: the loop goes on offering meanwhile.
            for channel in list(self._latest):
                self._send(channel, self._latest.pop(channel))

    def _send(self, channel: Channel, value: object) -> None:
        try:
            channel.publish(value)
        except Exception as error:  # noqa: BLE001 - one broken publisher must not stop the others
            self._report(f"Publishing failed: {error}")

"""Publishing from the control cycle without blocking it.

The counterpart of realtime_tools: a controller queues plain values; messages are built and
published outside the control cycle. On the wall clock a thread publishes the last value of each
publisher, so that a slow network never slows the loop. In lockstep the loop itself publishes all
values in the order of queueing, after the answer to the simulator.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeAlias, TypeVar

T = TypeVar("T")

LogEntry: TypeAlias = "tuple[Callable[[str], object], *tuple[str, ...]]"


class RealtimePublisher(Generic[T]):
    """Publisher for the control cycle: queues values that are published outside of it.

    Args:
        queue: Publish queue of the control loop, ``params.publish_queue`` of a controller.
        publish: Function called with each value outside the control cycle; builds and publishes
            the message.
    """

    __slots__ = ("_queue", "publish")

    def __init__(self, queue: PublishQueue, publish: Callable[[T], None]) -> None:
        self._queue = queue
        self.publish = publish

    def try_publish(self, value: T) -> None:
        """Queue a value for publishing without blocking; it must not be changed afterwards.

        On the wall clock the value replaces an earlier one that has not been published yet.
        """
        self._queue.put(self, value)


class PublishQueue:
    """Queue of values that controllers publish outside of the control cycle.

    Args:
        report: Function called with a sentence when publishing fails.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        self._report = report
        # Any: each publisher has values of its own type.
        self._queue: deque[tuple[RealtimePublisher[Any], object]] = deque()
        self._latest: dict[RealtimePublisher[Any], object] = {}
        self._wake = threading.Event()
        self._thread: threading.Thread | None = None
        self._stopping = False

    def start_thread(self) -> None:
        """Start a thread that publishes the latest value of each publisher after each cycle."""
        self._thread = threading.Thread(target=self._run, name="publish queue", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the publishing thread of `start_thread`, if any."""
        self._stopping = True
        self._wake.set()
        if self._thread is not None:
            self._thread.join(timeout=1.0)
            self._thread = None

    def put(self, publisher: RealtimePublisher[T], value: T) -> None:
        """Queue a publisher's value; with a thread, replace the publisher's unpublished value."""
        if self._thread is None:
            self._queue.append((publisher, value))
        else:
            self._latest[publisher] = value

    def flush(self) -> None:
        """Publish the queued values now, or wake the publishing thread if there is one."""
        if self._thread is not None:
            if self._latest:
                self._wake.set()
            return
        while self._queue:
            publisher, value = self._queue.popleft()
            self._send(publisher, value)

    def _run(self) -> None:
        while not self._stopping:
            self._wake.wait()
            self._wake.clear()
            # The keys are copied in one step, since the loop adds values at the same time.
            for publisher in list(self._latest):
                self._send(publisher, self._latest.pop(publisher))

    def _send(self, publisher: RealtimePublisher[Any], value: object) -> None:
        try:
            publisher.publish(value)
        except Exception as error:  # noqa: BLE001 - one broken publisher must not stop the others
            self._report(f"Publishing failed: {error}")


def realtime_log(queue: PublishQueue) -> RealtimePublisher[LogEntry]:
    """Return a realtime publisher of log lines: tuples of a logger's method and texts."""
    return RealtimePublisher(queue, _write_log)


def _write_log(entry: LogEntry) -> None:
    log, *lines = entry
    for line in lines:
        log(line)

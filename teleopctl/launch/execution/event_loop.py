"""Event loop of a launch: queued functions, timers and pending service calls on one thread."""

from __future__ import annotations

import heapq
import itertools
import os
import queue
import time
from collections.abc import Callable
from functools import partial

from teleopctl.errors import TeleopctlError
from teleopctl.launch.model.plan import LaunchTimer, Work
from teleopctl.launch.service_calls import CallSequence

# Windows lets no signal handler run while the main thread waits without end.
_LONGEST_WAIT_S = 0.2 if os.name == "nt" else None


class EventLoop:
    """Queue of functions and timers, called one after the other on one thread."""

    def __init__(self) -> None:
        # SimpleQueue may be filled from a signal handler, other queues may not.
        self._events: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._timers: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = itertools.count()

    @property
    def is_empty(self) -> bool:
        """Return whether no function is queued; timers do not count."""
        return self._events.empty()

    def put(self, function: Callable[[], None]) -> None:
        """Queue a function; threads and signal handlers may call this."""
        self._events.put(function)

    def after(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a delay; only the loop's own thread may call this."""
        due = time.monotonic() + seconds
        heapq.heappush(self._timers, (due, next(self._numbers), function))

    def handle_next(self) -> None:
        """Wait for the next function or timer and call it."""
        timeout = _LONGEST_WAIT_S
        if self._timers:
            left = max(0.0, self._timers[0][0] - time.monotonic())
            timeout = left if timeout is None else min(left, timeout)
        try:
            function = self._events.get(timeout=timeout)
        except queue.Empty:
            while self._timers and self._timers[0][0] <= time.monotonic():
                heapq.heappop(self._timers)[2]()
        else:
            function()


# A timer that takes longer keeps nobody waiting for the launch to be up.
_SOON_S = 30.0


class Timers:
    """Pending timers and service calls of a launch.

    Args:
        loop: Where their ends are told.
        on_change: Called when service calls or other work begin or end.
        fire: Called with a timer whose time has come.
        ended: Called when work has ended, with an error where it failed.
    """

    def __init__(
        self,
        loop: EventLoop,
        on_change: Callable[[], None],
        fire: Callable[[LaunchTimer], None],
        ended: Callable[[TeleopctlError | None], None],
    ) -> None:
        self._loop = loop
        self._on_change = on_change
        self._fire = fire
        self._ended = ended
        self._numbers = itertools.count()
        # When what waits for a timer is to come, in monotonic seconds.
        self._due: dict[int, tuple[float, LaunchTimer]] = {}
        self._works = 0
        self._asking = 0

    def __bool__(self) -> bool:
        """Whether there is something to wait for."""
        self._forget(lambda timer: timer.is_cancelled())
        return bool(self._due or self._works)

    def pending(self) -> int:
        """Return the number of timers that are due soon and of pending service calls.

        Any thread may ask.
        """
        soon = time.monotonic() + _SOON_S
        return self._asking + sum(due <= soon for due, _ in tuple(self._due.values()))

    def add(self, seconds: float, timer: LaunchTimer) -> None:
        """Start a timer."""
        number = next(self._numbers)
        self._due[number] = (time.monotonic() + seconds, timer)
        self._loop.after(seconds, partial(self._time_has_come, number))

    def begin(self, work: Work) -> None:
        """Start work, and wait for its end."""
        self._works += 1
        self._asking += isinstance(work, CallSequence)
        work.begin(lambda error: self._loop.put(partial(self._has_ended, work, error)))
        self._on_change()

    def shut_down(self) -> None:
        """Cancel all timers that the shutdown does not wait for."""
        self._forget(lambda timer: not timer.outlives_shutdown)

    def _forget(self, is_forgotten: Callable[[LaunchTimer], bool]) -> None:
        self._due = {
            number: entry for number, entry in self._due.items() if not is_forgotten(entry[1])
        }

    def _time_has_come(self, number: int) -> None:
        entry = self._due.pop(number, None)
        if entry is not None:
            self._fire(entry[1])

    def _has_ended(self, work: Work, error: TeleopctlError | None) -> None:
        self._works -= 1
        self._asking -= isinstance(work, CallSequence)
        self._on_change()
        self._ended(error)

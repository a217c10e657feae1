"""Event loop of a launch: queued functions, timers and pending service calls on one thread."""

from __future__ import annotations

import heapq
import itertools
import os
import queue
import time
from functools import partial

from teleopctl.base.typed import Callable
from teleopctl.errors import TeleopctlError
from teleopctl.launch.model.plan import LaunchTimer, Work
from teleopctl.launch.service_calls import CallSequence

# Windows runs no signal handler while the main thread waits without a timeout.
_LONGEST_WAIT_S = 0.2 if os.name == "nt" else None


class EventLoop:
    """Queue of functions and timed functions that one thread calls one after the other."""

    def __init__(self) -> None:
        # Signal handlers may put into a SimpleQueue, but not into other queues.
        self._events: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._timers: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = itertools.count()

    @property
    def is_empty(self) -> bool:
        """Whether no function is queued; timed functions do not count."""
        return self._events.empty()

    def put(self, function: Callable[[], None]) -> None:
        """Queue a function for the loop's thread; any thread or signal handler may call `put`."""
        self._events.put(function)

    def after(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a delay in seconds; only the loop's own thread may call this."""
        due = time.monotonic() + seconds
        heapq.heappush(self._timers, (due, next(self._numbers), function))

    def handle_next(self) -> None:
        """Call the timed functions that are due and the next queued one; wait if there is none."""
        # Before the queue: endless output of a process must not delay the signal that ends it.
        timeout = 0.0 if self._call_due() else _LONGEST_WAIT_S
        if self._timers:
            left = max(0.0, self._timers[0][0] - time.monotonic())
            timeout = left if timeout is None else min(left, timeout)
        try:
            function = self._events.get(timeout=timeout)
        except queue.Empty:
            self._call_due()
        else:
            function()

    def _call_due(self) -> bool:
        """Call the timed functions that are due; return whether there were any."""
        now = time.monotonic()
        due: list[Callable[[], None]] = []
        while self._timers and self._timers[0][0] <= now:
            due.append(heapq.heappop(self._timers)[2])
        for function in due:
            function()
        return bool(due)


# The wait for a launch to be up does not wait for later timers.
_SOON_S = 30.0


class Timers:
    """Pending timers and background work, such as service calls, that a launch waits for.

    Args:
        loop: Event loop that calls the functions below.
        on_change: Called when service calls or other work begin or end.
        fire: Called with a timer when its delay has passed.
        ended: Called when work has ended, with its error or None.
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
        # Timers with their due times, in seconds of the monotonic clock.
        self._due: dict[int, tuple[float, LaunchTimer]] = {}
        self._running_works = 0
        self._service_calls = 0

    def __bool__(self) -> bool:
        """Return whether timers or work are pending."""
        self._drop_timers(lambda timer: timer.is_cancelled())
        return bool(self._due or self._running_works)

    def pending(self) -> int:
        """Return the number of running service calls plus that of timers due within 30 s.

        Any thread may call this.
        """
        soon = time.monotonic() + _SOON_S
        return self._service_calls + sum(due <= soon for due, _ in tuple(self._due.values()))

    def add(self, seconds: float, timer: LaunchTimer) -> None:
        """Start a timer; ``fire`` is called with the timer after a delay in seconds."""
        number = next(self._numbers)
        self._due[number] = (time.monotonic() + seconds, timer)
        self._loop.after(seconds, partial(self._timer_due, number))

    def begin(self, work: Work) -> None:
        """Start background work; ``ended`` is called on the event loop when the work ends."""
        self._running_works += 1
        self._service_calls += isinstance(work, CallSequence)
        work.begin(lambda error: self._loop.put(partial(self._work_ended, work, error)))
        self._on_change()

    def shut_down(self) -> None:
        """Cancel all timers except those that outlive the shutdown of the launch."""
        self._drop_timers(lambda timer: not timer.outlives_shutdown)

    def _drop_timers(self, is_dropped: Callable[[LaunchTimer], bool]) -> None:
        self._due = {
            number: entry for number, entry in self._due.items() if not is_dropped(entry[1])
        }

    def _timer_due(self, number: int) -> None:
        entry = self._due.pop(number, None)
        if entry is not None:
            self._fire(entry[1])

    def _work_ended(self, work: Work, error: TeleopctlError | None) -> None:
        self._running_works -= 1
        self._service_calls -= isinstance(work, CallSequence)
        self._on_change()
        self._ended(error)

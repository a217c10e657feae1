"""Thread that calls a function at each trigger, as realtime_tools' AsyncFunctionHandler.

In lockstep there is no such thread: a trigger calls the function at once, so that a run is the same
each time. The caller uses results from the next cycle on in both cases.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.control.asynchronous.scheduling import schedule_thread
from teleopctl.control.lifecycle import ReturnType

if TYPE_CHECKING:
    from teleopctl.node import RcutilsLogger
    from teleopctl.robot import AsyncThread

# Longest wait for a running call before a transition, in seconds.
LONGEST_CALL_S = 5.0


class AsyncFunctionHandler:
    """Calls a function in a thread of its own: once per trigger, or by itself if detached.

    Args:
        function: Function of a time in nanoseconds and a period in seconds.
        name: Name of the thread.
        thread: Scheduling of the thread.
        rate: Rate of the calls of a detached thread in Hz.
        logger: Logger for the scheduling of the thread.
        uses_threads: Function that returns False in lockstep, where no thread is used.
    """

    def __init__(
        self,
        function: Callable[[int, float], ReturnType],
        name: str,
        thread: AsyncThread,
        rate: float,
        logger: RcutilsLogger,
        uses_threads: Callable[[], bool],
    ) -> None:
        self._function = function
        self._name = name
        self._scheduling = thread
        self._rate = rate
        self._logger = logger
        self._uses_threads = uses_threads
        self._thread: threading.Thread | None = None
        self._arguments = (0, 0.0)
        self._outcome: ReturnType | BaseException = ReturnType.OK
        self._lock = threading.Lock()
        self._go, self._idle, self._stopping = (threading.Event() for _ in range(3))
        self._idle.set()

    @property
    def is_busy(self) -> bool:
        """Whether a trigger would be missed, since the last call has not returned."""
        return not (self._scheduling.is_detached or self._idle.is_set())

    def trigger(self, time_ns: int, period: float) -> None:
        """Start a call; only if not busy. In lockstep, call the function and wait for it.

        Args:
            time_ns: Time of the cycle, nanoseconds.
            period: Seconds since the last call.
        """
        self._arguments = (time_ns, period)
        if not self._uses_threads():
            self._call()
            return
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            self._thread.start()
        if not self._scheduling.is_detached:
            self._idle.clear()
        self._go.set()

    def take_outcome(self) -> ReturnType:
        """Return the result of a call that failed, once, else OK; raise what the call raised.

        Raises:
            Exception: A call raised it.
        """
        outcome = self._outcome
        if outcome is ReturnType.OK:
            return outcome
        self._outcome = ReturnType.OK
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome

    def wait_until_idle(self, longest_s: float = LONGEST_CALL_S) -> bool:
        """Wait for the running call, and call no more until the next trigger; False if too long."""
        with self._lock:
            if self._scheduling.is_detached:
                self._go.clear()
        return self._idle.wait(longest_s)

    def stop_thread(self) -> None:
        """End the thread after the running call; it starts again with the next trigger."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._stopping.set()
        self._go.set()
        thread.join(LONGEST_CALL_S)
        self._go, self._idle, self._stopping = (threading.Event() for _ in range(3))
        self._idle.set()

    def _call(self) -> None:
        try:
            outcome = self._function(*self._arguments)
            if outcome is not ReturnType.OK:
                self._outcome = outcome
        except (Exception, SystemExit) as error:  # noqa: BLE001 - raised by `take_outcome`
            self._outcome = error

    def _run(self) -> None:
        schedule_thread(self._scheduling, self._logger)
        # Kept, since `stop_thread` replaces them.
        go, idle, stopping = self._go, self._idle, self._stopping
        while True:
            go.wait()
            if stopping.is_set():
                return
            if self._scheduling.is_detached:
                self._run_detached(go, idle, stopping)
            else:
                go.clear()
                self._call()
                idle.set()

    def _run_detached(
        self, go: threading.Event, idle: threading.Event, stopping: threading.Event
    ) -> None:
        """Call the function at the rate of the component, until `wait_until_idle`."""
        nominal, last = 1.0 / self._rate, 0.0
        deadline = time.monotonic()
        while not stopping.is_set():
            with self._lock:
                if not go.is_set():
                    return
                idle.clear()
            now = time.monotonic()
            self._arguments = (time.time_ns(), now - last if last else nominal)
            last = now
            self._call()
            idle.set()
            if self._outcome is not ReturnType.OK:
                go.clear()
            deadline = max(deadline + nominal, time.monotonic())
            stopping.wait(deadline - time.monotonic())

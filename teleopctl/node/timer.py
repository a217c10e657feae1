"""Timers on a clock, and rates that sleep by one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.node.callback_groups import CallbackGroup
from teleopctl.node.clock import Clock, ROSClock

if TYPE_CHECKING:
    from teleopctl.node.node import Node


class Timer:
    """Calls back each period of a clock; made by ``Node.create_timer``.

    Late calls are made up once, not piled up: after a long callback the next call is at the next
    multiple of the period, as in rcl.
    """

    def __init__(
        self,
        node: Node,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup,
        period_ns: int,
        clock: Clock,
        *,
        autostart: bool = True,
    ) -> None:
        if period_ns < 0:
            raise ValueError("timer period must not be negative")
        self._node = node
        self.callback = callback
        self.callback_group = callback_group
        self.clock = clock
        self._period_ns = period_ns
        self._last_call_ns = clock.nanoseconds()
        self._next_call_ns = self._last_call_ns + period_ns
        self._cancelled = not autostart
        if isinstance(clock, ROSClock):
            clock.on_jump(self._recheck)

    @property
    def timer_period_ns(self) -> int:
        """The period in nanoseconds; a new one counts from now."""
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, period_ns: int) -> None:
        self._period_ns = int(period_ns)
        self.reset()

    def is_ready(self) -> bool:
        """Tell whether a call is due."""
        return not self._cancelled and self.clock.nanoseconds() >= self._next_call_ns

    def is_canceled(self) -> bool:
        """Tell whether it was cancelled."""
        return self._cancelled

    def cancel(self) -> None:
        """Stop calling until :meth:`reset`."""
        self._cancelled = True

    def reset(self) -> None:
        """Start anew: the next call is one period from now."""
        self._cancelled = False
        self._last_call_ns = self.clock.nanoseconds()
        self._next_call_ns = self._last_call_ns + self._period_ns
        self._recheck()

    def time_since_last_call(self) -> int:
        """Return the nanoseconds since the last call."""
        return self.clock.nanoseconds() - self._last_call_ns

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds until the next call, None when cancelled."""
        if self._cancelled:
            return None
        return self._next_call_ns - self.clock.nanoseconds()

    def wall_time_until_next_call_s(self) -> float | None:
        """Return how long to wait in wall time; None when only an event can make it due."""
        if self._cancelled or (isinstance(self.clock, ROSClock) and self.clock.ros_time_is_active):
            return None
        return max(0.0, (self._next_call_ns - self.clock.nanoseconds()) / 1e9)

    def mark_called(self) -> None:
        """Schedule the next call; executors do so before they run the callback."""
        now_ns = self.clock.nanoseconds()
        self._last_call_ns = now_ns
        self._next_call_ns += self._period_ns
        if self._next_call_ns <= now_ns:
            missed = (now_ns - self._next_call_ns) // self._period_ns if self._period_ns else 0
            self._next_call_ns += (missed + 1) * self._period_ns

    def destroy(self) -> None:
        """Stop for good."""
        self._cancelled = True
        if isinstance(self.clock, ROSClock):
            self.clock.forget_on_jump(self._recheck)

    def _recheck(self) -> None:
        if executor := self._node.executor:
            executor.recheck()


class Rate:
    """Sleeps to a steady rate; another thread must spin the node meanwhile."""

    def __init__(self, timer: Timer) -> None:
        self._timer = timer
        self._tick = threading.Event()
        timer.callback = self._tick.set
        self._destroyed = False

    def sleep(self) -> None:
        """Sleep until the next tick, or until the context is shut down."""
        context = self._timer._node.context  # noqa: SLF001 (a rate is a part of its timer)
        context.on_shutdown(self._tick.set)
        try:
            self._tick.wait()
            self._tick.clear()
        finally:
            context.forget_on_shutdown(self._tick.set)

    def destroy(self) -> None:
        """Stop the timer and wake whoever sleeps."""
        self._timer.destroy()
        self._tick.set()

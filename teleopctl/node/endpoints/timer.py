"""Timers on a clock, and rates that sleep by one."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Self
from teleopctl.node.clock import Clock, ROSClock
from teleopctl.node.context import Context
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.exceptions import ROSInterruptException, TimerCancelledError
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore


class PeriodicTimer:
    """Timer without a callback: due once per period of a clock, until `call` marks it as called.

    Periods are spans as `Clock.elapsed_ns` counts them: of simulated time where a ROS clock follows
    ``/clock``, else of the steady clock. Late calls are made up once, not piled up: after a late
    call the next one is at the next multiple of the period, as in rcl.

    Attributes:
        listener: Told when the clock makes it due in a jump, or it starts anew, while somebody
            waits by hand.
    """

    listener: Callable[[], None] | None = None

    def __init__(self, period_ns: int, clock: Clock, *, autostart: bool = True) -> None:
        if period_ns < 0:
            raise ValueError("timer period must not be negative")
        self.clock = clock
        self._period_ns = period_ns
        self._last_call_ns = clock.elapsed_ns()
        self._next_call_ns = self._last_call_ns + period_ns
        self._cancelled = not autostart
        self._destroyed = False
        if isinstance(clock, ROSClock):
            clock.on_jump(self._follow_clock)

    @property
    def timer_period_ns(self) -> int:
        """Period in nanoseconds; a new period applies after the next call, as in rcl."""
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, period_ns: int) -> None:
        self._period_ns = int(period_ns)

    @property
    def handle(self) -> TimerHandle:
        """Handle of the timer as rclpy has it, which can be waited for."""
        return TimerHandle(self)

    @property
    def is_destroyed(self) -> bool:
        """Whether the timer was destroyed (ours)."""
        return self._destroyed

    def is_ready(self) -> bool:
        """Return whether a call is due."""
        return not self._cancelled and self.clock.elapsed_ns() >= self._next_call_ns

    def pending(self) -> int:
        """Return 1 while a call is due, else 0."""
        return int(self.is_ready())

    def is_canceled(self) -> bool:
        """Return whether the timer is cancelled."""
        return self._cancelled

    def cancel(self) -> None:
        """Cancel the timer until `reset`."""
        self._cancelled = True

    def restart(self, period_ns: int) -> None:
        """Restart the timer with another period, in nanoseconds (ours)."""
        self.timer_period_ns = period_ns
        self.reset()

    def reset(self) -> None:
        """Restart the period: the next call is due one period from now."""
        self._cancelled = self._destroyed
        self._last_call_ns = self.clock.elapsed_ns()
        self._next_call_ns = self._last_call_ns + self._period_ns
        self.tell_executor()

    def time_since_last_call(self) -> int:
        """Return the nanoseconds since the last call."""
        return self.clock.elapsed_ns() - self._last_call_ns

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds until the next call, None when cancelled."""
        if self._cancelled:
            return None
        return self._next_call_ns - self.clock.elapsed_ns()

    @property
    def waits_for_event(self) -> bool:
        """Whether the timer waits for a message on ``/clock`` rather than for time to pass."""
        return isinstance(self.clock, ROSClock) and self.clock.ros_time_is_active

    def count_call(self) -> bool:
        """Mark the due call as made and schedule the next; return False if cancelled."""
        if self._cancelled:
            return False
        now_ns = self.clock.elapsed_ns()
        self._last_call_ns = now_ns
        if self._period_ns == 0:
            self._next_call_ns = now_ns
        else:
            missed = max(0, now_ns - self._next_call_ns) // self._period_ns
            self._next_call_ns += (missed + 1) * self._period_ns
        return True

    def destroy(self) -> None:
        """Destroy the timer."""
        self._destroyed = True
        self._cancelled = True
        if isinstance(self.clock, ROSClock):
            self.clock.forget_on_jump(self._follow_clock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def _follow_clock(self) -> None:
        """Look at the clock anew: simulated time moved, or began or ended."""
        if self.clock.elapsed_ns() < self._last_call_ns:
            # Time went back (a simulation was reset): count from here, as rcl does.
            self.reset()
        elif not self.waits_for_event or self.is_ready():
            self.tell_executor()

    def tell_executor(self) -> None:
        """Notify the wait set, if any, that the timer's next call has changed."""
        if (listener := self.listener) is not None:
            listener()


class TimerHandle(Handle):
    """Handle of a timer whose calls the program counts itself."""

    entity: PeriodicTimer

    def is_timer_ready(self) -> bool:
        """Return whether a call is due."""
        return self.entity.is_ready()

    def call_timer(self) -> None:
        """Mark the due call as made: the next is due one period later.

        Raises:
            TimerCancelledError: It was cancelled.
        """
        if not self.entity.count_call():
            raise TimerCancelledError("the timer was cancelled")

    def cancel_timer(self) -> None:
        """Cancel the timer until `reset_timer`."""
        self.entity.cancel()

    def is_timer_canceled(self) -> bool:
        """Return whether the timer is cancelled."""
        return self.entity.is_canceled()

    def reset_timer(self) -> None:
        """Restart the period: the next call is due one period from now."""
        self.entity.reset()

    def time_since_last_call(self) -> int:
        """Return the nanoseconds since the last call."""
        return self.entity.time_since_last_call()

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds until the next call, None when cancelled."""
        return self.entity.time_until_next_call()

    def get_timer_period(self) -> int:
        """Return the period in nanoseconds."""
        return self.entity.timer_period_ns

    def change_timer_period(self, period_nsec: int) -> None:
        """Set the period in nanoseconds; the next call's time does not change."""
        self.entity.timer_period_ns = period_nsec


class Timer(PeriodicTimer):
    """Timer that calls back each period of a clock; made by ``Node.create_timer``."""

    def __init__(
        self,
        node: NodeCore,
        callback: Callable[[], object] | None,
        callback_group: CallbackGroup,
        period_ns: int,
        clock: Clock,
        *,
        autostart: bool = True,
    ) -> None:
        self._node = node
        self.callback = callback
        self.callback_group = callback_group
        super().__init__(period_ns, clock, autostart=autostart)

    @property
    def node(self) -> NodeCore:
        """Node of the timer."""
        return self._node

    def take(self) -> Callable[[], object] | None:
        """Mark the due call as made and return it; executors do so before calling back.

        Returns:
            The callback; None when there is none or the timer was cancelled meanwhile.
        """
        return self.callback if self.count_call() else None

    def tell_executor(self) -> None:
        """Notify the executor and the wait set that the timer's next call has changed."""
        super().tell_executor()
        if (executor := self._node.executor) is not None:
            executor.wake()


class Rate:
    """Sleeps at a fixed rate, while another thread spins the node."""

    def __init__(self, timer: Timer, context: Context) -> None:
        self.timer = timer
        self._context = context
        self._tick = threading.Event()
        timer.callback = self._tick.set

    def sleep(self) -> None:
        """Sleep until the next tick.

        Raises:
            ROSInterruptException: The context was shut down, or the rate was destroyed.
        """
        self._context.on_shutdown(self._tick.set)
        try:
            if self._context.ok() and not self.timer.is_canceled():
                self._tick.wait()
                self._tick.clear()
        finally:
            self._context.forget_on_shutdown(self._tick.set)
        if not self._context.ok() or self.timer.is_canceled():
            raise ROSInterruptException

    def destroy(self) -> None:
        """Destroy the timer and wake sleeping threads."""
        self.timer.destroy()
        self._tick.set()

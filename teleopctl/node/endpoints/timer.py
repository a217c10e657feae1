"""Timers on a clock, and rates."""

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
    """Base of timers, without a callback: due after each period, until `mark_called`.

    Periods are measured by `Clock.elapsed_ns`: in simulated time if a ROS clock follows ``/clock``,
    else by the steady clock. Missed calls are not repeated: after a late call the next one is at
    the next multiple of the period, as in rcl.

    Attributes:
        listener: Called when a time jump makes the timer due or the timer is restarted, while a
            wait set holds the timer.
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
            clock.on_time_update(self._follow_clock)

    @property
    def timer_period_ns(self) -> int:
        """Period in nanoseconds; a new value applies after the next call, as in rcl."""
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, period_ns: int) -> None:
        self._period_ns = int(period_ns)

    @property
    def handle(self) -> TimerHandle:
        """Handle of the timer, as in rclpy, to be added to a wait set."""
        return TimerHandle(self)

    @property
    def is_destroyed(self) -> bool:
        """Whether the timer was destroyed (ours)."""
        return self._destroyed

    def is_ready(self) -> bool:
        """Return whether a call of the timer is due."""
        return not self._cancelled and self.clock.elapsed_ns() >= self._next_call_ns

    def pending(self) -> int:
        """Return 1 while a call of the timer is due, else 0."""
        return int(self.is_ready())

    def is_canceled(self) -> bool:
        """Return whether the timer is canceled."""
        return self._cancelled

    def cancel(self) -> None:
        """Stop the timer until `reset`."""
        self._cancelled = True

    def restart(self, period_ns: int) -> None:
        """Set the period, in nanoseconds, and restart the timer (ours)."""
        self.timer_period_ns = period_ns
        self.reset()

    def reset(self) -> None:
        """Restart the timer, also a canceled one: the next call is due one period from now."""
        self._cancelled = self._destroyed
        self._last_call_ns = self.clock.elapsed_ns()
        self._next_call_ns = self._last_call_ns + self._period_ns
        self.notify_executor()

    def time_since_last_call(self) -> int:
        """Return the nanoseconds since the timer's last call, or since its reset."""
        return self.clock.elapsed_ns() - self._last_call_ns

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds to the timer's next call, negative if late; None if canceled."""
        if self._cancelled:
            return None
        return self._next_call_ns - self.clock.elapsed_ns()

    @property
    def waits_for_clock(self) -> bool:
        """Whether the timer waits for messages on ``/clock`` rather than for real time."""
        return isinstance(self.clock, ROSClock) and self.clock.ros_time_is_active

    def mark_called(self) -> bool:
        """Count a call as made, due or not, and schedule the next; return False if canceled."""
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
        """Cancel the timer for good, and detach it from its clock."""
        self._destroyed = True
        self._cancelled = True
        if isinstance(self.clock, ROSClock):
            self.clock.forget_on_time_update(self._follow_clock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def _follow_clock(self) -> None:
        """Update the timer after a change of simulated time or of the time source."""
        if self.clock.elapsed_ns() < self._last_call_ns:
            # Time jumped back (a simulation was reset): restart the period, as rcl does.
            self.reset()
        elif not self.waits_for_clock or self.is_ready():
            self.notify_executor()

    def notify_executor(self) -> None:
        """Notify the wait set that holds the timer, if any, that the next call has changed."""
        if (listener := self.listener) is not None:
            listener()


class TimerHandle(Handle):
    """Handle of a timer, with which a program checks and counts calls itself."""

    entity: PeriodicTimer

    def is_timer_ready(self) -> bool:
        """Return whether a call of the timer is due."""
        return self.entity.is_ready()

    def call_timer(self) -> None:
        """Count a call as made, without calling the callback, and schedule the next one.

        Raises:
            TimerCancelledError: The timer was cancelled.
        """
        if not self.entity.mark_called():
            raise TimerCancelledError("the timer was cancelled")

    def cancel_timer(self) -> None:
        """Stop the timer until `reset_timer`."""
        self.entity.cancel()

    def is_timer_canceled(self) -> bool:
        """Return whether the timer is canceled."""
        return self.entity.is_canceled()

    def reset_timer(self) -> None:
        """Restart the timer, also a canceled one: the next call is due one period from now."""
        self.entity.reset()

    def time_since_last_call(self) -> int:
        """Return the nanoseconds since the timer's last call, or since its reset."""
        return self.entity.time_since_last_call()

    def time_until_next_call(self) -> int | None:
        """Return the nanoseconds to the timer's next call, negative if late; None if canceled."""
        return self.entity.time_until_next_call()

    def get_timer_period(self) -> int:
        """Return the timer's period in nanoseconds."""
        return self.entity.timer_period_ns

    def change_timer_period(self, period_nsec: int) -> None:
        """Set the timer's period in nanoseconds; the time of the next call does not change."""
        self.entity.timer_period_ns = period_nsec


class Timer(PeriodicTimer):
    """Timer with a callback for each period of a clock; made by ``Node.create_timer``."""

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
        """Node that the timer was created on."""
        return self._node

    def take(self) -> Callable[[], object] | None:
        """Count the due call as made; return the callback, or None if canceled or without one."""
        return self.callback if self.mark_called() else None

    def notify_executor(self) -> None:
        """Notify the executor and the wait set, if any, that the timer's next call has changed."""
        super().notify_executor()
        if (executor := self._node.executor) is not None:
            executor.wake()


class Rate:
    """Rate that a thread sleeps by, while another thread spins the node."""

    def __init__(self, timer: Timer, context: Context) -> None:
        self.timer = timer
        self._context = context
        self._tick = threading.Event()
        timer.callback = self._tick.set

    def sleep(self) -> None:
        """Block until the next period of the rate begins; raise ROSInterruptException on shutdown.

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
        """Destroy the timer of the rate, and wake sleeping threads, whose `sleep` then raises."""
        self.timer.destroy()
        self._tick.set()

"""Methods of a node for timers, rates, guard conditions and waitables."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.interfaces import from_seconds
from teleopctl.node.clock import Clock
from teleopctl.node.context import Context
from teleopctl.node.node_core import NodeCore
from teleopctl.node.values.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)

if TYPE_CHECKING:
    from teleopctl.node.endpoints.guard_condition import GuardCondition
    from teleopctl.node.endpoints.timer import Rate, Timer
    from teleopctl.node.user_waitable import ServedWaitable, Waitable


class NodeTimers(NodeCore):
    """Base of nodes with the methods for timers, rates, guard conditions and waitables."""

    def __init__(
        self,
        node_name: str,
        context: Context | None,
        cli_args: Sequence[str] | None,
        namespace: str | None,
        use_global_arguments: bool,
    ) -> None:
        super().__init__(node_name, context, cli_args, namespace, use_global_arguments)
        # Replaced, never changed, so that executors may iterate without a lock.
        self._timers: tuple[Timer, ...] = ()
        self._guards: list[GuardCondition] = []
        self._waitables: list[ServedWaitable] = []
        self._endpoints_lock = threading.Lock()
        self._default_callback_group = MutuallyExclusiveCallbackGroup()

    @property
    def default_callback_group(self) -> CallbackGroup:
        """Callback group of the node's entities that were created without one."""
        return self._default_callback_group

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], object] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Create and return a timer on the node's clock, or on a given clock.

        Args:
            timer_period_sec: Period in seconds.
            callback: Called once per period.
            callback_group: Callback group of the callback; the node's default group if None.
            clock: Clock of the timer; the node's clock, which may follow simulated time, if None.
            autostart: Whether to start the timer; otherwise `Timer.reset` starts it.
        """
        from teleopctl.node.endpoints.timer import Timer

        timer = Timer(
            self,
            callback,
            callback_group or self._default_callback_group,
            from_seconds(timer_period_sec),
            clock or self._clock,
            autostart=autostart,
        )
        with self._endpoints_lock:
            self._timers = (*self._timers, timer)
        timer.callback_group.add_entity(timer)
        if self.executor is not None:
            self.executor.wake()
        return timer

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Return a new rate in Hz, for sleeping in a thread other than the spinning one.

        Raises:
            ValueError: The frequency is not positive.
        """
        if frequency <= 0:
            raise ValueError("frequency must be positive")
        from teleopctl.node.endpoints.timer import Rate

        # A separate group: the timer must be called while a callback sleeps by the rate.
        group = MutuallyExclusiveCallbackGroup()
        timer = self.create_timer(1.0 / frequency, None, group, clock)
        return Rate(timer, self._context)

    def create_guard_condition(
        self, callback: Callable[[], object], callback_group: CallbackGroup | None = None
    ) -> GuardCondition:
        """Return a new guard condition, whose triggers make the executor call ``callback``."""
        from teleopctl.node.endpoints.guard_condition import GuardCondition

        guard = GuardCondition(self, callback, callback_group or self._default_callback_group)
        guard.callback_group.add_entity(guard)
        with self._endpoints_lock:
            self._guards.append(guard)
        return guard

    @property
    def timers(self) -> tuple[Timer, ...]:
        """Timers of the node."""
        return self._timers

    @property
    def guards(self) -> list[GuardCondition]:
        """Guard conditions of the node."""
        return list(self._guards)

    def add_waitable(self, waitable: Waitable) -> None:
        """Add a waitable defined by the program, to be served by the node's executor."""
        from teleopctl.node.user_waitable import ServedWaitable

        def create_timer(clock: Clock) -> Timer:
            group = ReentrantCallbackGroup()
            return self.create_timer(0.0, None, group, clock, autostart=False)

        served = ServedWaitable(self, waitable, create_timer, self.destroy_timer)
        with self._endpoints_lock:
            self._waitables.append(served)
        served.notify_executor()

    def remove_waitable(self, waitable: Waitable) -> None:
        """Remove a waitable of `add_waitable`; unknown ones are ignored."""
        with self._endpoints_lock:
            removed = [served for served in self._waitables if served.waitable is waitable]
            self._waitables = [served for served in self._waitables if served not in removed]
        for served in removed:
            served.close()

    @property
    def waitables(self) -> list[Waitable]:
        """Waitables that were added by `add_waitable`, and not removed."""
        return [served.waitable for served in self._waitables]

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer of the node; return False if it is not the node's."""
        with self._endpoints_lock:
            if timer not in self._timers:
                return False
            self._timers = tuple(other for other in self._timers if other is not timer)
        timer.destroy()
        return True

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate of the node and its timer; return False if it is not the node's."""
        rate.destroy()
        return self.destroy_timer(rate.timer)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition of the node; return False if it is not one of the node's."""
        with self._endpoints_lock:
            if guard not in self._guards:
                return False
            self._guards.remove(guard)
        guard.destroy()
        return True

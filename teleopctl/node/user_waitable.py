"""Waitables defined by programs, and their service by executors."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.node.endpoints.waitable import NumberOfEntities, QueuingEntity as NodeWaitable
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.wait_set import WaitSet

if TYPE_CHECKING:
    from teleopctl.node.clock import Clock
    from teleopctl.node.endpoints.timer import Timer
    from teleopctl.node.node_core import NodeCore
    from teleopctl.node.values.future import Future


# A waitable that is not ready though its timer is due is checked again after this time, where rclpy
# checks it without a pause.
_RECHECK_NS = 1_000_000


class Waitable:
    """Base of waitables defined by programs, which implement its abstract methods.

    Args:
        callback_group: Group whose rules decide when `execute` may run.
    """

    def __init__(self, callback_group: CallbackGroup) -> None:
        self.callback_group = callback_group
        callback_group.add_entity(self)
        self._futures: list[Future[Any]] = []

    def __enter__(self) -> None:
        """Enter, as rclpy's waitables, which keep their entities alive in the block."""

    def __exit__(self, *_: object) -> None:
        """Leave; nothing to release here."""

    # Any, here and below: each waitable determines its data, which `execute` receives.

    def add_future(self, future: Future[Any]) -> None:
        """Store a future, without further effect, for rclpy programs."""
        self._futures.append(future)

    def remove_future(self, future: Future[Any]) -> None:
        """Remove a future of `add_future`."""
        self._futures.remove(future)

    def is_ready(self, wait_set: WaitSet) -> bool:
        """Return whether the waitable is ready, by its entities in the wait set; abstract."""
        raise NotImplementedError("Must be implemented by subclass")

    def take_data(self) -> Any:
        """Take and return the arrived data, which the executor passes to `execute`; abstract."""
        raise NotImplementedError("Must be implemented by subclass")

    async def execute(self, taken_data: Any) -> Any:
        """Handle the data that `take_data` returned, called by the executor; abstract."""
        raise NotImplementedError("Must be implemented by subclass")

    def get_num_entities(self) -> NumberOfEntities:
        """Return how many entities of each kind the waitable adds to a wait set; abstract."""
        raise NotImplementedError("Must be implemented by subclass")

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add the waitable's entities to a wait set, called before each check; abstract."""
        raise NotImplementedError("Must be implemented by subclass")


class ServedWaitable(NodeWaitable):
    """Adapter by which a node's executor serves a waitable defined by the program.

    The waitable is checked when it is added to the node, and whenever an entity that it added to
    the wait set at the last check has an arrival.

    Args:
        node: The node that the waitable was added to.
        waitable: The program's waitable.
        create_timer: Creates a timer of the node on a clock, for the waitable's timers.
        destroy_timer: Destroys such a timer.
    """

    def __init__(
        self,
        node: NodeCore,
        waitable: Waitable,
        create_timer: Callable[[Clock], Timer],
        destroy_timer: Callable[[Timer], object],
    ) -> None:
        self.node = node
        self.callback_group = waitable.callback_group
        self.waitable = waitable
        self._wait_set = WaitSet(node.context)
        self._create_timer = create_timer
        self._destroy_timer = destroy_timer
        self._alarms: dict[Clock, Timer] = {}
        self._is_due = True
        self._is_closed = False
        # Threads of a pool check one after the other; the waitable may remove itself in a check.
        self._check_lock = threading.RLock()

    def schedule_check(self) -> None:
        """Make the executor check soon whether the waitable is ready."""
        self._is_due = True
        self.notify_executor()

    def pending(self) -> int:
        """Return 1 while a check is scheduled, else 0."""
        return int(self._is_due and not self._is_closed)

    def take(self) -> Callable[[], object] | None:
        """Check the waitable; return the call of `execute` with its data, None if not ready.

        Other threads set `_is_due` at any time. So it is reset before the check, and afterwards
        only set: a value computed from what it was would overwrite theirs.
        """
        with self._check_lock:
            if self._is_closed:
                return None
            self._is_due = False
            self._wait_set.clear_entities()
            with self.waitable:
                self.waitable.add_to_wait_set(self._wait_set)
                self._wait_set.listen(self.schedule_check)
                self._wait_set.check_ready()
                is_ready = self.waitable.is_ready(self._wait_set)
                data = self.waitable.take_data() if is_ready else None
            if self._is_closed:
                return None
            self._set_alarms(is_ready=is_ready)
            if not is_ready:
                return None
            # More data than was taken may have arrived before.
            if self._wait_set.has_arrivals():
                self._is_due = True
            return functools.partial(self.waitable.execute, data)

    def _set_alarms(self, *, is_ready: bool) -> None:
        """Schedule checks for when the next timer of each clock is due.

        The time of each timer is read once: a timer that has become due since the check needs
        another check, not an alarm.
        """
        due: dict[Clock, int] = {}
        for timer in self._wait_set.timers():
            left_ns = timer.time_until_next_call()
            if left_ns is None:
                continue
            if left_ns <= 0:
                if is_ready or not self._wait_set.found_ready(timer):
                    self._is_due = True
                    continue
                left_ns = _RECHECK_NS
            due[timer.clock] = min(left_ns, due.get(timer.clock, left_ns))
        for clock in due.keys() - self._alarms.keys():
            alarm = self._alarms[clock] = self._create_timer(clock)
            alarm.callback = functools.partial(self._on_alarm, alarm)
        for clock, alarm in self._alarms.items():
            if clock in due:
                alarm.restart(due[clock])
            else:
                alarm.cancel()

    def _on_alarm(self, alarm: Timer) -> None:
        # In this order: a check that restarts the alarm in between is followed by another check.
        alarm.cancel()
        self.schedule_check()

    def close(self) -> None:
        """Stop checking the waitable, and destroy its timers."""
        with self._check_lock:
            self._is_closed = True
            self._is_due = False
            for alarm in self._alarms.values():
                self._destroy_timer(alarm)
            self._alarms.clear()
            self._wait_set.clear_entities()

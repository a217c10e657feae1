"""What a program has executors wait for besides the entities of its node."""

from __future__ import annotations

import functools
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


class Waitable:
    """Base of a program's own waitables (``rclpy.waitable.Waitable``); see ``Node.add_waitable``.

    Args:
        callback_group: Whose rules decide when it may execute.
    """

    def __init__(self, callback_group: CallbackGroup) -> None:
        self.callback_group = callback_group
        callback_group.add_entity(self)
        self._futures: list[Future[Any]] = []

    def __enter__(self) -> None:
        """Have what it waits for kept meanwhile."""

    def __exit__(self, *_: object) -> None:
        """Let it be destroyed again."""

    # Any, here and below: each waitable has its own, and `execute` gets what it has taken.

    def add_future(self, future: Future[Any]) -> None:
        """Add a future whose callbacks are to be run."""
        self._futures.append(future)

    def remove_future(self, future: Future[Any]) -> None:
        """Remove a future."""
        self._futures.remove(future)

    def is_ready(self, wait_set: WaitSet) -> bool:
        """Return whether `execute` is due."""
        raise NotImplementedError("Must be implemented by subclass")

    def take_data(self) -> Any:
        """Take the data that has arrived."""
        raise NotImplementedError("Must be implemented by subclass")

    async def execute(self, taken_data: Any) -> Any:
        """Handle the data that was taken."""
        raise NotImplementedError("Must be implemented by subclass")

    def get_num_entities(self) -> NumberOfEntities:
        """Return how many entities the waitable adds to a wait set."""
        raise NotImplementedError("Must be implemented by subclass")

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        """Add the waitable's entities to a wait set."""
        raise NotImplementedError("Must be implemented by subclass")


class ServedWaitable(NodeWaitable):
    """Serves a program's own waitable by the executor of a node.

    It is looked at when it is added to the node, and whenever something arrives for what it has
    added to the wait set then or the last time.

    Args:
        node: The node that it was added to.
        waitable: The program's.
        create_timer: Makes a timer of the node on a clock, for those that the waitable waits for.
        destroy_timer: Unmakes it.
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

    def look(self) -> None:
        """Schedule a check of the waitable by the executor."""
        self._is_due = True
        self.tell_executor()

    def pending(self) -> int:
        """Return 1 while a check is scheduled, else 0."""
        return int(self._is_due)

    def take(self) -> Callable[[], object] | None:
        """Return the waitable's `execute` call; None if it is not ready."""
        self._is_due = False
        self._wait_set.clear_entities()
        with self.waitable:
            self.waitable.add_to_wait_set(self._wait_set)
            self._wait_set.listen(self.look)
            self._wait_set.look()
            is_ready = self.waitable.is_ready(self._wait_set)
            data = self.waitable.take_data() if is_ready else None
        self._set_alarms()
        if not is_ready:
            return None
        # More than was taken may have come before.
        self._is_due = self._is_due or self._wait_set.has_arrivals()
        return functools.partial(self.waitable.execute, data)

    def _set_alarms(self) -> None:
        """Have it looked at when the next timer of each clock is due."""
        due: dict[Clock, int] = {}
        for timer in self._wait_set.timers():
            if (left_ns := timer.time_until_next_call()) is not None and left_ns > 0:
                due[timer.clock] = min(left_ns, due.get(timer.clock, left_ns))
        for clock in due.keys() - self._alarms.keys():
            alarm = self._alarms[clock] = self._create_timer(clock)
            alarm.callback = functools.partial(self._ring, alarm)
        for clock, alarm in self._alarms.items():
            if clock in due:
                alarm.restart(due[clock])
            else:
                alarm.cancel()

    def _ring(self, alarm: Timer) -> None:
        alarm.cancel()
        self.look()

    def close(self) -> None:
        """Stop waiting."""
        self._is_due = False
        for alarm in self._alarms.values():
            self._destroy_timer(alarm)
        self._alarms.clear()
        self._wait_set.clear_entities()

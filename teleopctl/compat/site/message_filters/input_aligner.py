"""Messages of several filters sorted by their stamps, with an output for each filter."""

import threading
from bisect import insort
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from message_filters.simple_filter import SimpleFilter
from teleopctl.node import ClockType, Duration, Node, Time, Timer

_NEVER = 2**63 - 1

# Any, here and below: messages of any type, and what a callback gets besides.


@dataclass
class QueueStatus:
    """State of an input of an `InputAligner`."""

    active: bool
    queue_size: int
    msgs_processed: int
    msgs_dropped: int


@dataclass
class _Input:
    """Queue of an input, sorted by stamp, and the expected stamp of the next message."""

    waiting: list[tuple[int, int, Any]] = field(default_factory=list)
    period: int = 0
    due: int = _NEVER
    active: bool = False
    taken: int = 0
    processed: int = 0
    dropped: int = 0

    def put(self, stamp: int, message: Any) -> None:
        # The number keeps messages of one stamp in order, and apart: they cannot be compared.
        insort(self.waiting, (stamp, self.taken, message), key=lambda each: each[:2])
        self.taken += 1

    def first(self) -> int:
        """Stamp of the first queued message, else of the expected one, else the latest time."""
        if self.waiting:
            self.active = True
            self.due = self.waiting[0][0] + self.period
            return self.waiting[0][0]
        return self.due if self.active else _NEVER


class InputAligner:
    """Passes on the messages of several filters in the order of their stamps.

    A message waits until every other input has one that is newer, or could not have an older one:
    its period says when the next is due. An input that stays silent for the timeout is no longer
    waited for until its next message.

    Args:
        timeout: How far the newest message may be ahead of an input that is waited for.
        filters: The filters that it takes from.
    """

    def __init__(self, timeout: Duration, filters: Sequence[SimpleFilter] | None = None) -> None:
        self.timeout = timeout
        self.name = ""
        self.lock = threading.RLock()
        self.input_connections: list[tuple[SimpleFilter, int]] = []
        self.signals: list[SimpleFilter] = []
        self.dispatch_timer: Timer | None = None
        self.event_queues: list[_Input] = []
        self._newest_in = 0
        self._newest_out = 0
        if filters is not None:
            self.connectInput(filters)

    def connectInput(self, filters: Sequence[SimpleFilter]) -> None:  # noqa: N802
        """Connect to filters instead of the present ones, and remove all callbacks."""
        with self.lock:
            self.disconnectAll()
            self.event_queues = [_Input() for _ in filters]
            self.signals = [SimpleFilter() for _ in filters]
            self.input_connections = [
                (each, each.registerCallback(self.add, index)) for index, each in enumerate(filters)
            ]

    def disconnectAll(self) -> None:  # noqa: N802
        """Disconnect from all filters."""
        with self.lock:
            for each, connection in self.input_connections:
                each.unregisterCallback(connection)
            self.input_connections = []

    def registerCallback(  # noqa: N802
        self, index: int, callback: Callable[..., object], *args: Any
    ) -> int:
        """Register a callback of an input; return the callback's number."""
        return self.signals[index].registerCallback(callback, *args)

    def setName(self, name: str) -> None:  # noqa: N802
        """Set the name of the aligner."""
        self.name = name

    def getName(self) -> str:  # noqa: N802
        """Return the name of the aligner."""
        return self.name

    def setInputPeriod(self, index: int, period: Duration) -> None:  # noqa: N802
        """Set the period between the stamps of an input."""
        self.event_queues[index].period = period.nanoseconds

    def getQueueStatus(self, index: int) -> QueueStatus:  # noqa: N802
        """Return the state of an input."""
        each = self.event_queues[index]
        return QueueStatus(each.active, len(each.waiting), each.processed, each.dropped)

    @property
    def last_in_ts(self) -> Time:
        """Newest received stamp."""
        return Time(nanoseconds=self._newest_in, clock_type=ClockType.ROS_TIME)

    @property
    def last_out_ts(self) -> Time:
        """Stamp of the message passed on last."""
        return Time(nanoseconds=self._newest_out, clock_type=ClockType.ROS_TIME)

    def add(self, msg: Any, queue_index: int) -> None:
        """Queue a message of an input; drop it if it is older than the one passed on last."""
        stamp = Time.from_msg(msg.header.stamp).nanoseconds
        with self.lock:
            if stamp < self._newest_out:
                self.event_queues[queue_index].dropped += 1
                return
            self._newest_in = max(self._newest_in, stamp)
            self.event_queues[queue_index].put(stamp, msg)

    def setupDispatchTimer(self, node: Node, update_rate: Duration) -> None:  # noqa: N802
        """Create a timer of a node that dispatches messages with period ``update_rate``."""
        period = update_rate.nanoseconds / 1e9
        self.dispatch_timer = node.create_timer(period, self.dispatchMessages)

    def dispatchMessages(self) -> None:  # noqa: N802
        """Pass on the messages that are due."""
        with self.lock:
            while any(each.waiting for each in self.event_queues) and self._put_out_first():
                pass

    def _put_out_first(self) -> bool:
        index, first = min(enumerate(self.event_queues), key=lambda each: each[1].first())
        if first.waiting:
            self._newest_out, _, message = first.waiting.pop(0)
            first.processed += 1
            self.signals[index].signalMessage(message)
        elif self._newest_in - first.due >= self.timeout.nanoseconds:
            first.active = False
        else:
            return False
        return True

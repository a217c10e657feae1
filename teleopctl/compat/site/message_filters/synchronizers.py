"""Synchronizers of messages with equal or similar stamps."""

import itertools
import threading
from collections.abc import Sequence
from typing import Any

from message_filters.simple_filter import SimpleFilter, time_of
from teleopctl.interfaces import to_nanoseconds
from teleopctl.node import Duration


class TimeSynchronizer(SimpleFilter):
    """Passes on one message of each filter when all have the same header stamp.

    Args:
        fs: The filters; the callbacks get their messages in this order.
        queue_size: How many messages of each filter wait for their partners.
    """

    def __init__(self, fs: Sequence[SimpleFilter], queue_size: int) -> None:
        super().__init__()
        self.queue_size = queue_size
        # A callback may feed a filter of the same synchronizer.
        self.lock = threading.RLock()
        self.connectInput(fs)

    def connectInput(self, fs: Sequence[SimpleFilter]) -> None:  # noqa: N802
        """Connect to filters."""
        self.queues: list[dict[int, Any]] = [{} for _ in fs]
        self.input_connections = [
            each.registerCallback(self.add, self.queues[index], index)
            for index, each in enumerate(fs)
        ]

    # Any: messages of any type.
    def add(self, msg: Any, my_queue: dict[int, Any], my_queue_index: int | None = None) -> None:  # noqa: ARG002
        """Process a message of a filter."""
        with self.lock:
            self._keep(my_queue, to_nanoseconds(msg.header.stamp), msg)
            common = set.intersection(*(set(queue) for queue in self.queues))
            for stamp in sorted(common):
                self._put_out([stamp] * len(self.queues))
                # What is older has lost its partners, as message_filters in C++ decides.
                for queue in self.queues:
                    for older in [each for each in queue if each < stamp]:
                        del queue[older]

    def _keep(self, queue: dict[int, Any], stamp: int, message: Any) -> None:
        queue[stamp] = message
        while len(queue) > self.queue_size:
            del queue[min(queue)]

    def _put_out(self, stamps: Sequence[int]) -> None:
        self.signalMessage(
            *(queue.pop(stamp) for queue, stamp in zip(self.queues, stamps, strict=True))
        )


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """Passes on one message of each filter when their stamps differ by less than a slop.

    Args:
        fs: The filters.
        queue_size: How many messages of each filter wait for their partners.
        slop: Longest difference, in seconds.
        allow_headerless: Whether a message without header counts at the time of its arrival.
    """

    def __init__(
        self,
        fs: Sequence[SimpleFilter],
        queue_size: int,
        slop: float,
        allow_headerless: bool = False,
    ) -> None:
        super().__init__(fs, queue_size)
        self.slop = Duration(seconds=slop)
        self.allow_headerless = allow_headerless

    # Any: as the base class has it.
    def add(self, msg: Any, my_queue: dict[int, Any], my_queue_index: int | None = None) -> None:
        """Process a message of a filter."""
        time = time_of(msg, self.allow_headerless, "message_filters_approx")
        if time is None:
            return
        stamp, slop = time.nanoseconds, self.slop.nanoseconds
        with self.lock:
            self._keep(my_queue, stamp, msg)
            near = [
                [stamp]
                if index == my_queue_index
                else sorted(
                    (s for s in queue if abs(s - stamp) <= slop), key=lambda s: abs(s - stamp)
                )
                for index, queue in enumerate(self.queues)
            ]
            # The nearest come first; a message that its own queue dropped has no partners.
            for stamps in itertools.product(*near):
                known = all(s in queue for queue, s in zip(self.queues, stamps, strict=True))
                if known and max(stamps) - min(stamps) < slop:
                    self._put_out(stamps)
                    return

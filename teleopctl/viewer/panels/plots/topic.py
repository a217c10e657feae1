"""A topic of which numbers are plotted: listened to once, however many of them are."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import (
    NumericField,
    field_reader,
    numeric_fields,
    to_nanoseconds,
    to_seconds,
)
from teleopctl.viewer.displays.topic_qos import topic_qos
from teleopctl.viewer.panels.plots.series import Series

if TYPE_CHECKING:
    from teleopctl.node import QoSProfile
    from teleopctl.viewer.displays.base import Stage

# Stamps further from the node's clock than this are of another one; see `PlottedTopic`.
_SAME_CLOCK_S = 10.0
# A stamp that lies so far before the last one is no late message: time has begun anew.
_JUMP_BACK_S = 1.0


class PlottedTopic:
    """Subscription of a plotted topic, which collects samples of its fields.

    The time of a message is its stamp. Where it has none, or the first one is more than ten seconds
    from the node's clock (a recording that is played, a machine whose clock is wrong), it is the
    time of receipt, so that several topics fit in one plot.

    Args:
        stage: What to listen with.
        name: The topic.
        type_name: Its type.

    Attributes:
        name: The topic.
        type_name: Its type.
        series: The numbers that are noted, by path.
        newest: The newest message.
        came_s: When it came, on the steady clock; before the first one, when this began.
    """

    def __init__(self, stage: Stage, name: str, type_name: str) -> None:
        self.name = name
        self.type_name = type_name
        self.series: dict[str, Series] = {}
        self.newest: Any = None
        self._readers: dict[str, Callable[[Any], Any]] = {}
        self._stage = stage
        self._qos: QoSProfile | None = None
        self._end: Callable[[], None] | None = None
        self._takes_stamps: bool | None = None
        self._last_s = -float("inf")
        self.came_s = time.monotonic()

    def begin(self) -> None:
        """Subscribe with the publishers' QoS; again after that has changed."""
        qos = topic_qos(self._stage.node, self.name, {})
        if self._end is not None and qos == self._qos:
            return
        self.end()
        self._qos = qos
        self._end = self._stage.subscribe(self.name, self.type_name, self._take, qos)

    def end(self) -> None:
        """Unsubscribe."""
        if self._end is not None:
            self._end()
            self._end = None

    @property
    def is_listening(self) -> bool:
        """Whether the topic is subscribed to."""
        return self._end is not None

    def clear(self) -> None:
        """Drop all samples."""
        self._takes_stamps = None
        self._last_s = -float("inf")
        for one in self.series.values():
            one.clear()

    def follow(self, path: str) -> Series:
        """Collect samples of a field from now on."""
        if path not in self.series:
            self._readers[path] = field_reader(path)
            self.series[path] = Series()
        return self.series[path]

    def forget(self, path: str) -> None:
        """Stop collecting samples of a field."""
        self.series.pop(path, None)
        self._readers.pop(path, None)

    def fields(self) -> list[NumericField]:
        """Return the numeric fields of the newest message."""
        return [] if self.newest is None else numeric_fields(self.newest)

    def _take(self, message: Any) -> None:
        self.newest, self.came_s = message, time.monotonic()
        if not self.series:
            return
        time_s = self._time_of(message)
        if time_s < self._last_s - _JUMP_BACK_S:
            self.clear()
            time_s = self._time_of(message)
        self._last_s = max(self._last_s, time_s)
        for path, one in self.series.items():
            one.add(time_s, _number(self._readers[path], message))

    def _time_of(self, message: Any) -> float:
        now_s = self._stage.node.get_clock().now().nanoseconds * 1e-9
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        if stamp is None:
            return now_s
        stamp_s = to_seconds(to_nanoseconds(stamp))
        if self._takes_stamps is None:
            self._takes_stamps = abs(stamp_s - now_s) < _SAME_CLOCK_S
        return stamp_s if self._takes_stamps else now_s


def _number(read: Callable[[Any], Any], message: Any) -> float:
    """A number of a message; NaN where this message lacks it."""
    try:
        return float(read(message))
    except (InvalidMessageError, TypeError, ValueError, OverflowError):
        return float("nan")

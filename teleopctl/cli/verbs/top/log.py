"""Log messages that nodes publish on ``/rosout``."""

from __future__ import annotations

import threading
from collections import deque
from datetime import datetime
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.base.printable import printable_text
from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import LoggingSeverity, qos_profile_rosout_default

if TYPE_CHECKING:
    from teleopctl.node import Node

MOST_LINES = 1000
_LONGEST_TEXT = 2000


class LogLine(NamedTuple):
    """Local time, level, node and text of a message of ``/rosout``."""

    time: str
    level: int
    node: str
    text: str


class LogBuffer:
    """Subscription to ``/rosout`` that keeps the newest 1000 messages.

    Args:
        node: Node that subscribes to ``/rosout``.
    """

    def __init__(self, node: Node) -> None:
        self._lock = threading.Lock()
        self._lines: deque[tuple[int, LogLine]] = deque(maxlen=MOST_LINES)
        self._count = 0
        node.create_subscription(
            get_message("rcl_interfaces/msg/Log"),
            "/rosout",
            self._receive,
            qos_profile_rosout_default,
            immediate=True,
        )

    def lines(self, level: int = LoggingSeverity.INFO) -> list[tuple[int, LogLine]]:
        """Return the kept messages of a level and above with their numbers, oldest first."""
        with self._lock:
            return [pair for pair in self._lines if pair[1].level >= level]

    def text(self, number: int) -> str:
        """Return the text of the message with a number from `lines`; empty if it was dropped."""
        with self._lock:
            return next((line.text for count, line in self._lines if count == number), "")

    def _receive(self, message: Any) -> None:
        stamp_s = to_nanoseconds(message.stamp) / 1e9
        line = LogLine(
            datetime.fromtimestamp(stamp_s).strftime("%H:%M:%S.%f")[:-3],
            message.level,
            message.name,
            printable_text(message.msg[:_LONGEST_TEXT]),
        )
        with self._lock:
            self._count += 1
            self._lines.append((self._count, line))

"""Errors logged by a controller manager, read from ``/rosout``."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import LoggingSeverity, Node, qos_profile_rosout_default

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rcl_interfaces.msg import Log

DESCRIPTION_RECEIVED = "Received robot description from topic."
"""Beginning of the log line about a received robot description."""
NOT_RELOADED = "Controller manager: Cannot reload controller libraries because"
"""Beginning of the log line with the reason why controllers were not reloaded, as in ROS 2."""
DESCRIPTION_REFUSED = (
    "The published robot description file (URDF) seems not to be genuine. The following error was "
    "caught:"
)
"""Beginning of the log line with the reason why a description was rejected, as in ROS 2."""

# A log message may arrive after the response of the service.
_CAUSE_WITHIN_S = 3.0
_OWN_WORDS_WITHIN_S = 0.3
# Within this time a log message arrives that the subscription receives at all.
_MISSED_AFTER_S = 0.5
# Tolerance for different clocks of two machines.
_SKEW_NS = 100_000_000


class ManagerLog:
    """Collector of errors that a controller manager and its controllers log on ``/rosout``.

    Args:
        node: Node of the subscription.
        manager: Full name of the controller manager.

    Attributes:
        refusal: Reason why the manager rejected the last robot description; None if no rejection
            was logged.
    """

    def __init__(self, node: Node, manager: str) -> None:
        self.refusal: str | None = None
        self._name = manager.strip("/").replace("/", ".")
        # Time, logger and text of each error.
        self._errors: list[tuple[int, str, str]] = []
        self._changed = threading.Condition()
        self._node = node
        self._subscribe()

    def _subscribe(self) -> None:
        """Subscribe to ``/rosout``: to lines of the past, too, since the topic is latched."""
        self._node.create_subscription(
            get_message("rcl_interfaces/msg/Log"),
            "/rosout",
            self._received,
            qos_profile_rosout_default,
            immediate=True,
        )

    def cause(self, controller: str, since_ns: int) -> str | None:
        """Wait for and return the last error logged about a controller; None after 3 s.

        Args:
            controller: Name of the controller.
            since_ns: Time of the failed request in nanoseconds; earlier errors are ignored.
        """
        self._wait_for(lambda: self._about(controller, since_ns))
        with self._changed:
            # The controller's own log line is closer to the cause, and may arrive later.
            self._changed.wait_for(lambda: self._own(controller, since_ns), _OWN_WORDS_WITHIN_S)
            return self._own(controller, since_ns) or self._about(controller, since_ns)

    def last_error(self, beginning: str, since_ns: int) -> str | None:
        """Wait up to 3 s for a manager's error with a given beginning; return the rest or None."""

        def found() -> str | None:
            texts = self._texts(self._name, since_ns)
            return next((text for text in texts if text.startswith(beginning)), None)

        text = self._wait_for(found)
        return text and text.removeprefix(beginning).strip()

    def _wait_for(self, found: Callable[[], str | None]) -> str | None:
        """Wait up to 3 s until a function finds an error; return it, or None."""
        with self._changed:
            if self._changed.wait_for(found, _MISSED_AFTER_S):
                return found()
        # The manager may have logged it before it knew of the subscription, and nothing since: a
        # new one receives it as a line of the past.
        self._subscribe()
        with self._changed:
            self._changed.wait_for(found, _CAUSE_WITHIN_S - _MISSED_AFTER_S)
            return found()

    def _texts(self, name: str, since_ns: int) -> Iterator[str]:
        """Return the errors of a logger since a time, the last first."""
        return (
            text
            for stamp_ns, logger, text in reversed(self._errors)
            if logger == name and stamp_ns >= since_ns - _SKEW_NS
        )

    def _own(self, controller: str, since_ns: int) -> str | None:
        own = f"{self._name.rpartition('.')[0]}.{controller}".lstrip(".")
        return next(self._texts(own, since_ns), None)

    def _about(self, controller: str, since_ns: int) -> str | None:
        of_manager = self._texts(self._name, since_ns)
        found = next((text for text in of_manager if f"'{controller}'" in text), None)
        return found or self._own(controller, since_ns)

    def _received(self, log: Log) -> None:
        if log.name == self._name:
            if log.msg.startswith(DESCRIPTION_REFUSED):
                self.refusal = log.msg.removeprefix(DESCRIPTION_REFUSED).strip()
            elif log.msg.startswith(DESCRIPTION_RECEIVED):
                self.refusal = None
        if log.level >= LoggingSeverity.ERROR:
            with self._changed:
                self._errors.append((to_nanoseconds(log.stamp), log.name, log.msg))
                self._changed.notify_all()

"""What a controller manager logs, for a process that asks it: its services tell no reasons."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from teleopctl.interfaces import get_message
from teleopctl.node import LoggingSeverity, Node, qos_profile_rosout_default

if TYPE_CHECKING:
    from rcl_interfaces.msg import Log

DESCRIPTION_RECEIVED = "Received robot description from topic."
"""How a manager begins what it says of a description."""
DESCRIPTION_REFUSED = (
    "The published robot description file (URDF) seems not to be genuine. The following error was "
    "caught:"
)
"""How a manager, ROS 2's too, begins to say why it does not accept a description."""

# The log goes another way than the answer of a service, and may come after it.
_CAUSE_WITHIN_S = 3.0
_OWN_WORDS_WITHIN_S = 0.3


class ManagerLog:
    """Listens to ``/rosout`` for one controller manager and its controllers.

    Args:
        node: The node that listens.
        manager: The manager's full name.

    Attributes:
        refusal: Why the manager does not accept the robot description that came last; None where
            it does, or has not said so.
    """

    def __init__(self, node: Node, manager: str) -> None:
        self.refusal: str | None = None
        self._name = manager.strip("/").replace("/", ".")
        self._errors: list[tuple[str, str]] = []
        self._changed = threading.Condition()
        node.create_subscription(
            get_message("rcl_interfaces/msg/Log"),
            "/rosout",
            self._received,
            qos_profile_rosout_default,
            immediate=True,
        )

    def cause(self, controller: str) -> str | None:
        """The last error about a controller, also of before this object was made.

        None where none comes within a moment.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._about(controller), _CAUSE_WITHIN_S)
            # What the controller itself says is closer to the cause, and comes by another way.
            self._changed.wait_for(lambda: self._own(controller), _OWN_WORDS_WITHIN_S)
            return self._own(controller) or self._about(controller)

    def _own(self, controller: str) -> str | None:
        own = f"{self._name.rpartition('.')[0]}.{controller}".lstrip(".")
        return next((text for name, text in reversed(self._errors) if name == own), None)

    def _about(self, controller: str) -> str | None:
        of_manager = (text for name, text in reversed(self._errors) if name == self._name)
        told = next((text for text in of_manager if f"'{controller}'" in text), None)
        return told or self._own(controller)

    def _received(self, log: Log) -> None:
        if log.name == self._name:
            if log.msg.startswith(DESCRIPTION_REFUSED):
                self.refusal = log.msg.removeprefix(DESCRIPTION_REFUSED).strip()
            elif log.msg.startswith(DESCRIPTION_RECEIVED):
                self.refusal = None
        if log.level >= LoggingSeverity.ERROR:
            with self._changed:
                self._errors.append((log.name, log.msg))
                self._changed.notify_all()

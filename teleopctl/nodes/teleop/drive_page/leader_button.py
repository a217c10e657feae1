"""Button of the drive page that engages a leader arm, for a running ``teleop_device``."""

from __future__ import annotations

from typing import Any

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Node, qos_profile_latched

_DEVICE = "/teleop_device"

# Any, here and below: message classes are generated at run time from definitions.


class LeaderButton:
    """Client of the service of a ``teleop_device`` that engages a leader arm, and its state.

    Args:
        node: Node of the endpoints.
    """

    def __init__(self, node: Node) -> None:
        self._values: dict[str, str] = {}
        kind = get_service("std_srvs/srv/SetBool")
        self._engage = node.create_client(kind, f"{_DEVICE}/engage")
        self._request: Any = kind.Request
        node.create_subscription(
            get_message("diagnostic_msgs/msg/DiagnosticStatus"),
            f"{_DEVICE}/state",
            self._on_state,
            qos_profile_latched,
        )

    def press(self, *, engages: bool) -> None:
        """Request that the arm follows its leader, or no longer does."""
        if self._engage.service_is_ready():
            # A refusal is also part of the device's state.
            self._engage.call_async(self._request(data=engages))

    def state(self) -> dict[str, Any] | None:
        """Return the state of the leader arm for JSON; None if no device has a leader."""
        if not self._values or not self._engage.service_is_ready():
            return None
        return {
            "is_engaged": self._values.get("engaged") == "true",
            "doing": self._values.get("doing", ""),
            "problem": self._values.get("problem", ""),
        }

    def _on_state(self, message: Any) -> None:
        self._values = {value.key: value.value for value in message.values}

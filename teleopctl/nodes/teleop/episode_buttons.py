"""Episode buttons of a teleoperation device, for a running ``episode_recorder``."""

from __future__ import annotations

from typing import Any

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Node, qos_profile_latched
from teleopctl.teleop import EPISODE_STEPS

_RECORDER = "/episode_recorder"

# Any, here and below: message classes are generated at run time from definitions.


class EpisodeButtons:
    """Client of an episode recorder's services, and its state.

    Args:
        node: Node of the endpoints.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._state: dict[str, str] = {}
        self._note = ""
        trigger = get_service("std_srvs/srv/Trigger")
        self._clients = {
            step: node.create_client(trigger, f"{_RECORDER}/{step}") for step in EPISODE_STEPS
        }
        self._request: Any = trigger.Request
        node.create_subscription(
            get_message("diagnostic_msgs/msg/DiagnosticStatus"),
            f"{_RECORDER}/state",
            self._on_state,
            qos_profile_latched,
        )

    def press(self, action: str) -> None:
        """Send the request of an episode button; ``success`` also saves the episode."""
        steps = ["success", "save"] if action == "success" else [action]
        self._call(steps)

    def state(self) -> dict[str, str] | None:
        """Return the state of the recorder; None if none runs."""
        if not self._state or not self._clients["start"].service_is_ready():
            return None
        return {**self._state, "note": self._note}

    def _call(self, steps: list[str]) -> None:
        client = self._clients[steps[0]]
        if not client.service_is_ready():
            return

        def answered(future: Any) -> None:
            response = None if future.exception() is not None else future.result()
            self._note = "" if response is None else str(response.message)
            if response is not None and response.success and steps[1:]:
                self._call(steps[1:])

        client.call_async(self._request()).add_done_callback(answered)

    def _on_state(self, message: Any) -> None:
        values = {value.key: value.value for value in message.values}
        self._state = {"state": message.message, **values}

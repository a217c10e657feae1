"""The controllers of a robot as they are, followed by the events of their manager."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Node, qos_profile_latched

_LIST = "controller_manager_msgs/srv/ListControllers"

# Any: message classes are generated at run time from definitions.


class ControllerWatch:
    """Calls a function with the controllers of ``controller_manager`` after each of their changes.

    Args:
        node: Node of the endpoints; the manager is in its namespace.
        on_controllers: Called with the ControllerState messages and the manager's namespace.
    """

    def __init__(self, node: Node, on_controllers: Callable[[list[Any], str], object]) -> None:
        self._on_controllers = on_controllers
        self._namespace = node.get_namespace()
        manager = f"{self._namespace.rstrip('/')}/controller_manager"
        self._client = node.create_client(get_service(_LIST), f"{manager}/list_controllers")
        self._is_asking = False
        # Published by managers since Jazzy; before, `query` asks when servo begins to move.
        node.create_subscription(
            get_message("controller_manager_msgs/msg/ControllerManagerActivity"),
            f"{manager}/activity",
            lambda _: self.query(),
            qos_profile_latched,
        )

    def query(self) -> None:
        """Ask for the controllers, unless a question is on its way or nobody would answer."""
        if self._is_asking or not self._client.service_is_ready():
            return
        self._is_asking = True
        future = self._client.call_async(get_service(_LIST).Request())
        future.add_done_callback(self._answered)

    # Any: the future of a response.
    def _answered(self, future: Any) -> None:
        self._is_asking = False
        if (response := future.result()) is not None:
            self._on_controllers(list(response.controller), self._namespace)

"""Requests to other nodes that hold a robot stopped to release it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any

from teleopctl.interfaces import get_service
from teleopctl.node import RELEASE_SERVICE, RELEASE_TYPE, Node

# Time in which the service of a node that has just stopped the robot is found in the graph, s.
_FOUND_S = 1.0


class StopReleaser:
    """Caller of the services by which other nodes release a robot that they hold stopped.

    Args:
        node: Node of the clients.
        note: Called with a text for the operator if a node has no such service.
    """

    def __init__(self, node: Node, note: Callable[[str], object]) -> None:
        self._node, self._note = node, note
        # Any: classes of services are generated at run time.
        self._type: Any = get_service(RELEASE_TYPE)
        self._clients: dict[str, Any] = {}
        # Nodes whose service is not known yet, and until when it is looked for, s.
        self._unasked: dict[str, float] = {}

    def ask(self, names: Iterable[str]) -> None:
        """Ask nodes to release the robot, now or once their services are in the graph.

        Args:
            names: Full names of the nodes.
        """
        until_s = time.monotonic() + _FOUND_S
        for name in names:
            self._unasked[name] = until_s
        self.ask_again()

    def ask_again(self) -> None:
        """Ask the nodes whose services have not been known so far; call it from time to time."""
        if not self._unasked:
            return
        for name, until_s in tuple(self._unasked.items()):
            client = self._clients.get(name)
            if client is None:
                client = self._clients[name] = self._node.create_client(
                    self._type, RELEASE_SERVICE.replace("~", name)
                )
            is_ready = client.service_is_ready()
            if not is_ready and time.monotonic() < until_s:
                continue
            if self._unasked.pop(name, None) is None:
                continue  # another thread has asked it
            if is_ready:
                client.call_async(self._type.Request())
            else:
                self._note(f"The robot is stopped by {name}: release it there")

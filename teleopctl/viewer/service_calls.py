"""Asynchronous calls of other nodes' services, and the servers of a service in the graph.

Each call ends with a callback: with the response, or with a sentence about its failure.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_service
from teleopctl.node import Clock, ClockType

if TYPE_CHECKING:
    from teleopctl.node import Client, Node, ResponseFuture
    from teleopctl.viewer.panels.base import Page

_TIMEOUT_S = 5.0
# Time in which a server is found that has just appeared in the graph, and between two looks, s.
_FOUND_S, _LOOK_S = 1.0, 0.05
# Services and topics that every node has, which have commands of their own.
_OF_EVERY_NODE = (
    *("/describe_parameters", "/get_parameter_types", "/get_parameters", "/list_parameters"),
    *("/set_parameters", "/set_parameters_atomically", "/get_type_description"),
    *("/parameter_events", "/rosout", "/get_logger_levels", "/set_logger_levels"),
)

# Any: messages, whose classes are created from definitions at run time.


def servers_of(node: Node, service: str, type_name: str) -> list[str]:
    """Return the sorted full names of nodes that offer a service below their own names.

    Args:
        node: Node whose graph is read.
        service: Name of the service below its node's name, such as ``list_parameters``.
        type_name: Type of the service.
    """
    return sorted(
        name.removesuffix(f"/{service}")
        for name, types in node.get_service_names_and_types()
        # The graph lists the services of clients too.
        if name.endswith(f"/{service}") and type_name in types and node.count_services(name)
    )


def is_of_every_node(name: str) -> bool:
    """Return whether a topic or service is one that every node has, or a part of an action.

    Args:
        name: Full name of the topic or service.
    """
    return name.endswith(_OF_EVERY_NODE) or "/_action/" in name


class ServiceCalls:
    """Asynchronous service calls with timeouts, on clients that are kept until `close`.

    Args:
        page: The viewer's node, on whose thread the callbacks are called.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._node = page.node
        self._clients: dict[str, Client[Any, Any]] = {}
        self._timers: set[Any] = set()

    @property
    def is_waiting(self) -> bool:
        """Whether a call has not been answered yet."""
        return bool(self._timers)

    def call(
        self,
        service: str,
        type_name: str,
        then: Callable[[Any], object],
        failed: Callable[[str], object],
        *,
        timeout_s: float | None = None,
        **fields: Any,
    ) -> None:
        """Call a service without waiting; pass the response to ``then``, or a fault to ``failed``.

        Args:
            service: Name of the service.
            type_name: Type of the service, such as ``std_srvs/srv/Trigger``.
            then: Called with the response.
            failed: Called with a sentence if there is no server, or no response in time.
            timeout_s: Time to wait for the response, in seconds of wall time; None for 5 s.
            fields: Fields of the request.
        """
        timeout_s = _TIMEOUT_S if timeout_s is None else timeout_s
        client = self._clients.get(service)
        if client is None:
            client = self._node.create_client(get_service(type_name), service)
            self._clients[service] = client
        request = client.srv_type.Request(**fields)
        if client.service_is_ready():
            self._send(client, request, then, failed, timeout_s)
            return
        end_s = time.monotonic() + _FOUND_S

        def look() -> None:
            if timer not in self._timers:
                return  # queued twice
            is_ready = client.service_is_ready()
            if not is_ready and time.monotonic() < end_s:
                return
            self._end(timer)
            if is_ready:
                self._send(client, request, then, failed, timeout_s)
            else:
                failed(f"{service} has no server")

        timer = self._start(_LOOK_S, look)

    def _send(
        self,
        client: Client[Any, Any],
        request: Any,
        then: Callable[[Any], object],
        failed: Callable[[str], object],
        timeout_s: float,
    ) -> None:
        """Send a request to a server that is known."""
        future = client.call_async(request)

        def expired() -> None:
            client.remove_pending_request(future)
            self._end(timer)
            failed(f"{client.srv_name} did not respond within {timeout_s:g} s")

        timer = self._start(timeout_s, expired)

        def answered(done: ResponseFuture[Any]) -> None:
            if not done.cancelled() and timer in self._timers:
                self._end(timer)
                then(done.result())

        future.add_done_callback(self._page.on_node_thread(answered))

    def _start(self, period_s: float, callback: Callable[[], None]) -> Any:
        """Return a new timer of wall time that calls back on the node's thread."""
        timer = self._node.create_timer(
            period_s,
            self._page.on_node_thread(callback),
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        self._timers.add(timer)
        return timer

    def _end(self, timer: Any) -> None:
        self._timers.discard(timer)
        self._node.destroy_timer(timer)

    def close(self) -> None:
        """Drop all pending calls without calling back, and destroy the clients."""
        for timer in tuple(self._timers):
            self._end(timer)
        for client in self._clients.values():
            self._node.destroy_client(client)
        self._clients.clear()

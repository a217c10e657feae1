"""Services of other nodes, called so that the page never waits.

Each call ends: with the response, or with a sentence that says who did not answer.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_service
from teleopctl.node import Clock, ClockType

if TYPE_CHECKING:
    from teleopctl.node import Client, ResponseFuture
    from teleopctl.viewer.page.page import Page

_PATIENCE_S = 5.0

# Any stands for messages: their classes are made at run time, from definitions.


class ServiceCalls:
    """Calls services asynchronously, and keeps their clients until `close`.

    Args:
        page: Whose node calls; the answers are brought to its thread.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._node = page.node
        self._clients: dict[str, Client[Any, Any]] = {}
        self._timers: set[Any] = set()

    def call(
        self,
        service: str,
        type_name: str,
        then: Callable[[Any], object],
        failed: Callable[[str], object],
        *,
        patience_s: float | None = None,
        **fields: Any,
    ) -> None:
        """Call a service; the response or the failure goes to a callback.

        Args:
            service: Its name.
            type_name: Its type, such as ``std_srvs/srv/Trigger``.
            then: Called with the response.
            failed: Called instead, with a sentence, when there is none.
            patience_s: How long to wait for the response, in seconds of wall time; None for a few.
            fields: The request's fields.
        """
        patience_s = _PATIENCE_S if patience_s is None else patience_s
        client = self._clients.get(service)
        if client is None:
            client = self._node.create_client(get_service(type_name), service)
            self._clients[service] = client
        if not client.service_is_ready():
            failed(f"{service} is not there")
            return
        future = client.call_async(client.srv_type.Request(**fields))

        def expired() -> None:
            client.remove_pending_request(future)
            self._end(timer)
            failed(f"{service} did not answer within {patience_s:g} s")

        timer = self._node.create_timer(
            patience_s, self._page.on(expired), clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self._timers.add(timer)

        def answered(done: ResponseFuture[Any]) -> None:
            if not done.cancelled() and timer in self._timers:
                self._end(timer)
                then(done.result())

        future.add_done_callback(self._page.on(answered))

    def _end(self, timer: Any) -> None:
        self._timers.discard(timer)
        self._node.destroy_timer(timer)

    def close(self) -> None:
        """Drop all pending calls; their callbacks are not called."""
        for timer in tuple(self._timers):
            self._end(timer)
        for client in self._clients.values():
            self._node.destroy_client(client)
        self._clients.clear()

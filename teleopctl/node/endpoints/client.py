"""Service clients."""

from __future__ import annotations

import collections
import functools
import itertools
import threading
import time
from collections.abc import Callable

from teleopctl.base.interrupts import transport_callback
from teleopctl.base.typed import TYPE_CHECKING, Any, Generic, cast
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import RequestT, ResponseT, serialize
from teleopctl.node.endpoints.service_endpoint import ServiceEndpoint, ServiceInfo
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.exceptions import ExternalShutdownException, ServiceUnavailableError
from teleopctl.node.values.future import Future, ResultT
from teleopctl.node.values.qos import QoSProfile
from teleopctl.wire import (
    TIME_LIMITS,
    Attachment,
    EntityKind,
    InvalidMessageCounter,
    no_response_text,
    read_response,
    send_request,
)

if TYPE_CHECKING:
    import zenoh

    from teleopctl.interfaces import ServiceType
    from teleopctl.node.node_core import NodeCore
    from teleopctl.node.values.callback_groups import Scheduler


def _do_nothing() -> None:
    """Do nothing, so that a spinning thread returns."""


# Any, here and below: the types of the request and the response are not used.
class ResponseFuture(Future[ResultT]):
    """Future of a service response; done callbacks run in the executor of the client's node.

    Args:
        client: Client that sent the request.
    """

    def __init__(self, client: Client[Any, Any]) -> None:
        super().__init__()
        self._executor = client.executor_of_node
        self._client = client
        self._settled = threading.Event()
        self._when_unanswered: list[Callable[[], object]] = []
        self.on_end(self._settled.set)

    @transport_callback
    def mark_unanswered(self) -> None:
        """Record that no server will respond any more; wake waiting threads (ours)."""
        self._settled.set()
        self._notify_if_unanswered()

    def wait_until_settled(self, timeout_sec: float | None = None) -> bool:
        """Block until the future ends or no server is left to respond; False on timeout (ours).

        Returns:
            False on timeout, which is in seconds of wall time; the request stays pending.
        """
        return self._wait_for(self._settled.wait, timeout_sec)

    def is_settled(self) -> bool:
        """Return whether the future has ended, or no server is left to respond (ours)."""
        return self._settled.is_set()

    def on_unanswered(self, listener: Callable[[], object]) -> None:
        """Register a function to call (Zenoh thread or at once) if no server responds (ours)."""
        self._when_unanswered.append(listener)
        if self._settled.is_set():
            self._notify_if_unanswered()

    def _notify_if_unanswered(self) -> None:
        while self._when_unanswered:
            try:
                listener = self._when_unanswered.pop()
            except IndexError:
                return  # another thread calls it
            if not self.done():
                listener()

    def _call(self, callback: Callable[[Future[ResultT]], object]) -> None:
        self._client.schedule_callback(functools.partial(callback, self))

    def wait_for_response(self, timeout_sec: float | None = None) -> ResultT | None:
        """Block until the response, and return it; None on timeout; raise without a server (ours).

        For commands, which report a missing server; `Client.call` waits as in rclpy.

        Args:
            timeout_sec: Longest wait in seconds of wall time; None waits forever.

        Returns:
            The response; None on timeout, after which the response would be dropped.

        Raises:
            ServiceUnavailableError: No server responds.
            ExternalShutdownException: The context was shut down during the wait.
        """
        settled = self.wait_until_settled(timeout_sec)
        if self.ended():
            return self.result()
        self._client.remove_pending_request(self)
        if settled:
            raise ServiceUnavailableError(no_response_text(self._client.service_name))
        return None

    def wait_until_answered(self, timeout_sec: float | None = None) -> ResultT | None:
        """Block until the response, even without a server, and return it; None on timeout (ours).

        Args:
            timeout_sec: Longest wait in seconds of wall time; None waits forever.

        Returns:
            The response; None on timeout, after which the response would be dropped.

        Raises:
            ExternalShutdownException: The context was shut down during the wait.
        """
        if self._wait_for(self.wait, timeout_sec):
            return self.result()
        self._client.remove_pending_request(self)
        return None

    def _wait_for(self, wait: Callable[[float | None], bool], timeout_sec: float | None) -> bool:
        context = self._client.node.context
        context.on_shutdown(self.cancel)
        try:
            ended = context.ok() and wait(timeout_sec)
        finally:
            context.forget_on_shutdown(self.cancel)
        if not context.ok() and (self.cancelled() or not ended):
            self._client.remove_pending_request(self)
            raise ExternalShutdownException
        return ended


class Client(ServiceEndpoint, QueuingEntity, Generic[RequestT, ResponseT]):
    """Service client; made by ``Node.create_client``.

    A request that reaches no server, or whose server disappears, stays pending until the caller
    drops it (`remove_pending_request`, a timeout): servers that start later never receive it.
    Unlike in rclpy, ``call()`` may be used inside a callback: responses do not need the executor.
    """

    def __init__(
        self,
        node: NodeCore,
        srv_type: type[ServiceType[RequestT, ResponseT]],
        name: str,
        callback_group: CallbackGroup,
        qos: QoSProfile,
    ) -> None:
        super().__init__(node, EntityKind.SC, name, srv_type.TYPE_NAME, qos)
        # For type checkers, a service class is an object whose attributes are classes.
        self.srv_type: ServiceType[RequestT, ResponseT] = cast(
            "ServiceType[RequestT, ResponseT]", srv_type
        )
        self.callback_group = callback_group
        self._sequence = itertools.count(1)
        self._lock = threading.Lock()
        self._pending: dict[Future[ResponseT], int] = {}  # their sequence numbers
        self._callbacks: collections.deque[Callable[[], object]] = collections.deque()
        self._news = False
        self.refusals = InvalidMessageCounter(f"an answer of '{name}'", node.get_logger().error)
        self._announce()

    @property
    def srv_name(self) -> str:
        """Fully qualified name of the service."""
        return self.name

    @property
    def service_name(self) -> str:
        """Fully qualified name of the service."""
        return self.name

    def service_is_ready(self) -> bool:
        """Return whether a server of the client's name and type is in the graph."""
        return bool(self.node.matched(EntityKind.SS, self.name, self.type_name))

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Block until a matching server is in the graph; return False on timeout or shutdown."""
        return self.node.wait_for_match(EntityKind.SS, self.name, self.type_name, 1, timeout_sec)

    def is_server_frozen(self) -> bool:
        """Return whether servers are in the graph but all suspended, as by SIGSTOP (ours).

        A server that is stopped by a signal stays in the graph and does not respond. The check
        then takes about a second, else milliseconds.
        """
        from teleopctl.wire import is_frozen

        servers = self.node.matched(EntityKind.SS, self.name, self.type_name)
        session = self.node.context.session
        return bool(servers) and all(is_frozen(session, server.zid) for server in servers)

    def executor_of_node(self) -> Scheduler | None:
        """Return the executor of the client's node, or None (ours)."""
        return self.node.executor

    def call_async(self, request: RequestT) -> ResponseFuture[ResponseT]:
        """Send a request; return a future of the response.

        Returns:
            A future of the response, which stays pending while no server responds.

        Raises:
            TypeError: The request is of another type.
            TeleopctlError: A field has a value that its type cannot hold.
        """
        return self.send(request)[1]

    def send(self, request: RequestT) -> tuple[int, ResponseFuture[ResponseT]]:
        """Send a request; return its sequence number and a future of the response (ours)."""
        self._check_alive()
        if not isinstance(request, self.srv_type.Request):
            raise TypeError(f"Expected {self.srv_type.Request}, got {type(request)}")
        payload = serialize(request)
        future: ResponseFuture[ResponseT] = self.make_future()
        sequence = next(self._sequence)
        with self._lock:
            self._pending[future] = sequence
        # Published first: a server of this process may receive the request before this continues.
        if self._introspection is not None:
            self._introspection.request_sent(self.gid, sequence, request)

        def receive(reply: zenoh.Reply) -> None:
            self._receive(reply, sequence, future)

        def end(is_expired: bool) -> None:
            if is_expired and not future.ended():
                self.refusals.refuse(
                    "it did not come while the request was open, and the more requests a process "
                    "sends the sooner it gives them up"
                )
            future.mark_unanswered()

        send_request(
            self.node.context.session,
            self.key,
            payload,
            Attachment(sequence, time.time_ns(), self.gid),
            receive,
            end,
            TIME_LIMITS.next_s(self.key),
        )
        return sequence, future

    def call(self, request: RequestT, timeout_sec: float | None = None) -> ResponseT | None:
        """Send a request, block until the response, and return it; None on timeout.

        Args:
            request: Request of the client's service type.
            timeout_sec: Longest wait in seconds of wall time; None waits forever.

        Raises:
            ExternalShutdownException: The context was shut down during the wait.
        """
        return self.call_async(request).wait_until_answered(timeout_sec)

    # Any: a value derived from a response may be of any type.
    def make_future(self) -> ResponseFuture[Any]:
        """Return a new future, for a value derived from a response of this client (ours)."""
        future: ResponseFuture[Any] = ResponseFuture(self)
        future.on_end(self._notify_of_response)
        return future

    def schedule_callback(self, callback: Callable[[], object]) -> None:
        """Queue a function for the node's executor, or for the next executor of the node."""
        self._callbacks.append(callback)
        self.notify_executor()

    def _notify_of_response(self) -> None:
        self._news = True
        self.notify_executor()

    def pending(self) -> int:
        """Return how many callbacks wait for the executor, at least 1 after a new response."""
        return len(self._callbacks) or int(self._news)

    def take(self) -> Callable[[], object] | None:
        """Remove and return the oldest queued callback; None without a callback or new response.

        A response without callbacks counts as an item too: a program that spins once and then
        checks the future waits for it.
        """
        # Cleared only if it was set, so that a response in between is not lost.
        if news := self._news:
            self._news = False
        try:
            return self._callbacks.popleft()
        except IndexError:
            return _do_nothing if news else None

    def get_pending_request(self, sequence_number: int) -> Future[ResponseT]:
        """Return the future of a request that has no response yet.

        Raises:
            KeyError: No request of this sequence number waits for a response.
        """
        with self._lock:
            for future, sequence in self._pending.items():
                if sequence == sequence_number:
                    return future
        raise KeyError(sequence_number)

    def remove_pending_request(self, future: Future[Any]) -> None:
        """Cancel the future of a request, so that its response is dropped."""
        with self._lock:
            self._pending.pop(future, None)
        future.cancel()

    def _receive(self, reply: zenoh.Reply, sequence: int, future: Future[ResponseT]) -> None:
        """Accept the first response to the request; responses of further servers are dropped."""
        if future.ended():
            return
        sample = reply.ok
        if sample is None:
            return
        try:
            response, meta = read_response(sample, sequence, self.srv_type.Response)
        except TeleopctlError as error:
            # Another server may respond correctly; else the caller waits until the query ends.
            self.refusals.refuse(error.message)
            return
        with self._lock:
            self._pending.pop(future, None)
        if self._introspection is not None:
            self._introspection.response_received(self.gid, sequence, response)
        self._settle(future, response, ServiceInfo(meta, time.time_ns()))

    def _settle(
        self,
        future: Future[ResponseT],
        response: ResponseT,
        info: ServiceInfo,  # noqa: ARG002 -- for subclasses
    ) -> None:
        """Set the response as the result of its future."""
        future.set_result(response)

    def _close(self) -> None:
        if self._introspection is not None:
            self._introspection.close()
        with self._lock:
            pending, self._pending = self._pending, {}
        for future in pending:
            future.cancel()

"""Service servers."""

from __future__ import annotations

import contextlib
import functools
import time
from collections.abc import Awaitable, Callable

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Any, Generic, TypeAlias, cast
from teleopctl.errors import InvalidMessageError, TeleopctlError
from teleopctl.interfaces import RequestT, ResponseT, deserialize, serialize
from teleopctl.node.endpoints.receive_queues import KeepLastQueue
from teleopctl.node.endpoints.service_endpoint import ServiceEndpoint, ServiceInfo
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.handle import Handle
from teleopctl.node.values.qos import QoSProfile
from teleopctl.wire import (
    EntityKind,
    InvalidMessageCounter,
    decode_attachment,
    direct_callback,
    encode_attachment,
)

if TYPE_CHECKING:
    from teleopctl.interfaces import ServiceType
    from teleopctl.node.node_core import NodeCore


# The depth of a QoS profile suits the burst of one client; a thousand entries hold the requests of
# a whole system, in 20 MB.
_MINIMUM_DEPTH = 1000

# Fills the given response and returns it, or returns another response.
ServiceCallback: TypeAlias = Callable[[RequestT, ResponseT], ResponseT | Awaitable[ResponseT]]


class ServiceHandle(Handle):
    """Handle of a service server, with which a program takes and answers requests itself."""

    # Any, here and below: requests and responses of the service's type.
    entity: Service[Any, Any]

    def service_take_request(
        self,
        request_type: type[object],  # noqa: ARG002 -- rclpy's; the service has the type
    ) -> tuple[Any, ServiceInfo | None]:
        """Remove and return the oldest request and its header; a pair of None if there is none."""
        return self.entity.take_request() or (None, None)

    def service_send_response(self, response: Any, header: ServiceInfo) -> None:
        """Send the response to the request with a header."""
        self.entity.send_response(response, header)


class Service(ServiceEndpoint, QueuingEntity, Generic[RequestT, ResponseT]):
    """Service server; made by ``Node.create_service``.

    Requests wait in a queue of the QoS profile's depth, at least a thousand. A full queue drops the
    oldest request, which ends the wait of its client.

    Args:
        node: Node of the service.
        srv_type: Service class with ``Request`` and ``Response``.
        name: Fully qualified name of the service.
        callback: ``callback(request, response) -> response``; may be a coroutine function.
        callback_group: Callback group of the callback.
        qos: QoS profile.
        immediate: Whether to call the callback on Zenoh's receiving thread, without an executor;
            for callbacks that are short and need no lock that another callback may hold.

    Attributes:
        refusals: Counts and logs dropped requests: malformed ones, and those of a full queue.
    """

    def __init__(
        self,
        node: NodeCore,
        srv_type: type[ServiceType[RequestT, ResponseT]],
        name: str,
        callback: ServiceCallback[RequestT, ResponseT],
        callback_group: CallbackGroup,
        qos: QoSProfile,
        *,
        immediate: bool = False,
    ) -> None:
        super().__init__(node, EntityKind.SS, name, srv_type.TYPE_NAME, qos)
        # For type checkers, a service class is an object whose attributes are classes.
        self.srv_type: ServiceType[RequestT, ResponseT] = cast(
            "ServiceType[RequestT, ResponseT]", srv_type
        )
        self.callback = callback
        self.callback_group = callback_group
        self._depth = max(qos.queue_depth or 0, _MINIMUM_DEPTH)
        self._queries: KeepLastQueue[tuple[zenoh.Query, int]] = KeepLastQueue(self._depth)
        self.refusals = InvalidMessageCounter(f"a request to '{name}'", node.get_logger().error)
        receive = self._answer_now if immediate else self._queue
        self._channel: Any = node.context.session.declare_queryable(
            self.key, direct_callback(receive), complete=True
        )
        self._announce()

    @property
    def srv_name(self) -> str:
        """Fully qualified name of the service."""
        return self.name

    @property
    def service_name(self) -> str:
        """Fully qualified name of the service."""
        return self.name

    @property
    def handle(self) -> ServiceHandle:
        """Handle of the service server, as in rclpy."""
        return ServiceHandle(self, self.name)

    def pending(self) -> int:
        """Return how many requests wait for the executor."""
        return len(self._queries)

    def take(self) -> Callable[[], object] | None:
        """Remove the oldest request; return the call that answers it, None if there is none."""
        arrival = self._queries.take()
        return None if arrival is None else functools.partial(self._handle, *arrival)

    def take_request(self) -> tuple[RequestT, ServiceInfo] | None:
        """Remove and return the oldest request and its header; None without a valid one (ours).

        Returns:
            The request, and its header for `send_response`; None if no request is queued, or the
            oldest one is malformed.
        """
        arrival = self._queries.take()
        return None if arrival is None else self._read(*arrival)

    def _queue(self, query: zenoh.Query) -> None:
        if len(self._queries) == self._depth:
            self.refusals.refuse(f"{self._depth} are waiting, the oldest is dropped")
        self._queries.put((query, time.time_ns()), 0)
        self.notify_executor()

    def _answer_now(self, query: zenoh.Query) -> None:
        try:
            self._handle(query, time.time_ns())
        except Exception:  # noqa: BLE001 (must not end Zenoh's thread)
            import traceback

            self.refusals.refuse(f"the callback failed:\n{traceback.format_exc()}")

    def _read(self, query: zenoh.Query, received_ns: int) -> tuple[RequestT, ServiceInfo] | None:
        """Decode a request; count, log and return None if it is malformed.

        A query that is dropped without a reply ends the client's wait.
        """
        try:
            payload = query.payload
            meta = decode_attachment(query.attachment.to_bytes()) if query.attachment else None
            if payload is None or meta is None:
                raise InvalidMessageError("it came without payload or readable attachment")
            request = deserialize(payload.to_bytes(), self.srv_type.Request)
        except TeleopctlError as error:
            self.refusals.refuse(error.message)
            return None
        if self._introspection is not None:
            self._introspection.request_received(meta.gid, meta.sequence, request)
        return request, ServiceInfo(meta, received_ns, query)

    def _handle(self, query: zenoh.Query, received_ns: int) -> Any:
        """Answer one request."""
        taken = self._read(query, received_ns)
        if taken is None:
            return None
        request, header = taken
        return self._serve(request, _Reply(self, header))

    def _serve(self, request: RequestT, reply: Callable[[ResponseT], None]) -> Any:
        outcome = self.callback(request, self.srv_type.Response())
        if hasattr(outcome, "send"):
            return _reply_later(reply, cast("Awaitable[ResponseT]", outcome))
        reply(outcome)  # type: ignore[arg-type] # no coroutine, and send_response checks the type
        return None

    def send_response(self, response: ResponseT, header: ServiceInfo) -> None:
        """Send the response to a request, given the request's header.

        Args:
            response: Response message of the service.
            header: Header of the request.

        Raises:
            TypeError: ``response`` is not a response of the service.
        """
        request, _, query = header
        if not isinstance(response, self.srv_type.Response):
            raise TypeError(
                f"the callback of service '{self.name}' returned {type(response).__name__}, "
                f"not {self.srv_type.Response.__name__}"
            )
        payload = serialize(response)
        # The reply fails if the callback itself has shut down or destroyed the service.
        assert query is not None, "the header of a response matches no request"
        with contextlib.suppress(zenoh.ZError):
            # Published first: a client of this process may get the response before this continues.
            if self._introspection is not None:
                self._introspection.response_sent(request.gid, request.sequence, response)
            query.reply(
                self.key,
                payload,
                attachment=encode_attachment(request.sequence, time.time_ns(), request.gid),
            )

    def _close(self) -> None:
        if self._introspection is not None:
            self._introspection.close()
        self._channel.undeclare()
        # Dropping a request ends the wait of its client.
        self._queries.close()


class _Reply:
    """Function that sends the response to a request, with the GID of the client.

    `send_response` is looked up at the call: programs replace it.
    """

    __slots__ = ("_header", "_service", "sender")

    def __init__(self, service: Service[Any, Any], header: ServiceInfo) -> None:
        self._service, self._header = service, header
        self.sender = header.attachment.gid

    def __call__(self, response: Any) -> None:
        self._service.send_response(response, self._header)


async def _reply_later(reply: Callable[[ResponseT], None], answer: Awaitable[ResponseT]) -> None:
    reply(await answer)


class DeferringService(Service[RequestT, ResponseT]):
    """Service server whose callback gets a ``reply`` function to send the response now or later.

    A request whose ``reply`` is garbage-collected unused ends the wait of its client. For the
    services of actions, which continue after the response, or respond late.

    Args:
        node: Node of the service.
        srv_type: Service class with ``Request`` and ``Response``.
        name: Fully qualified name of the service.
        callback: ``callback(request, reply)``; ``reply(response)`` may be called once, from any
            thread. The callback may be a coroutine function.
        callback_group: Callback group of the callback.
        qos: QoS profile.
    """

    def __init__(
        self,
        node: NodeCore,
        srv_type: type[ServiceType[RequestT, ResponseT]],
        name: str,
        callback: Callable[[RequestT, Callable[[ResponseT], None]], object],
        callback_group: CallbackGroup,
        qos: QoSProfile,
    ) -> None:
        self._defer = callback
        super().__init__(node, srv_type, name, _never_called, callback_group, qos)

    def _serve(self, request: RequestT, reply: Callable[[ResponseT], None]) -> Any:
        return self._defer(request, reply)


def _never_called(_: RequestT, response: ResponseT) -> ResponseT:
    return response

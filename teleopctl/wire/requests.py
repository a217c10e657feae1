"""Service requests and responses on the wire."""

from __future__ import annotations

import _thread
import os
import time

import zenoh

from teleopctl.base.interrupts import transport_callback
from teleopctl.base.typed import TYPE_CHECKING, Generic, Protocol, TypeVar, cast
from teleopctl.errors import InvalidMessageError, TeleopctlError, UnavailableError
from teleopctl.interfaces import ResponseT, deserialize, serialize, type_hash
from teleopctl.wire.attachment import GID_SIZE, Attachment, decode_attachment, encode_attachment
from teleopctl.wire.callbacks import direct_callback
from teleopctl.wire.keys import topic_key
from teleopctl.wire.session import domain_id

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from teleopctl.interfaces import RequestT, ServiceType

_Response_co = TypeVar("_Response_co", covariant=True)

# Sequence number of the only request of a client.
_ONLY = 1

LONGEST_LIMIT_S = 1e7
"""Longest time limit of a request: four months, practically unlimited; Zenoh requires a limit."""


def send_request(
    session: zenoh.Session,
    key: str,
    request: bytes | bytearray,
    attachment: Attachment,
    on_reply: Callable[[zenoh.Reply], None],
    on_end: Callable[[bool], None],
    limit_s: float = LONGEST_LIMIT_S,
) -> None:
    """Send a service request; call `on_reply` for each reply and `on_end` after the last.

    Args:
        session: Session of the client.
        key: Zenoh key of the service.
        request: Request as CDR bytes.
        attachment: Sequence number and source time of the request, and GID of the client.
        on_reply: Called with each reply, on a thread of Zenoh.
        on_end: Called on that thread after the last reply, with whether the time limit of the
            request was reached. Zenoh's own reply about the time limit does not always arrive.
        limit_s: Time limit, until which Zenoh keeps memory of the request, in seconds; a process
            that sends many takes it from `TimeLimits`.
    """
    deadline = time.monotonic() + limit_s
    session.get(
        key,
        direct_callback(on_reply, lambda: on_end(time.monotonic() >= deadline)),
        target=zenoh.QueryTarget.ALL_COMPLETE,
        consolidation=zenoh.ConsolidationMode.NONE,
        timeout=limit_s,
        payload=request,
        attachment=encode_attachment(*attachment),
    )


def read_response(
    sample: zenoh.Sample, sequence: int, type_: type[ResponseT]
) -> tuple[ResponseT, Attachment]:
    """Decode the reply of a server; return the response and its attachment.

    Args:
        sample: Sample of the reply.
        sequence: Sequence number of the request.
        type_: Class of the response.

    Raises:
        InvalidMessageError: The reply is malformed, or belongs to another request.
    """
    meta = decode_attachment(sample.attachment.to_bytes()) if sample.attachment else None
    if meta is None or meta.sequence != sequence:
        raise InvalidMessageError("it came without a readable attachment, or with another's")
    return deserialize(sample.payload.to_bytes(), type_), meta


def no_response_text(service: str, refused: str = "") -> str:
    """Return the error text for a service request that got no valid response."""
    why = f"its answer was dropped: {refused}" if refused else "no server for it"
    return f"service '{service}' did not answer: {why}"


class ServiceRequest(Generic[ResponseT]):
    """Service request sent at construction without a node, for commands that send one and exit.

    To a server it is a request like any other. It takes a third of the time that a node and a
    client take to start.

    Example:
        ``ServiceRequest(session, Trigger, "/calibrate", Trigger.Request()).wait_for_response(5.0)``

    Args:
        session: Session that sends the request.
        type_: Class of the service.
        service: Fully qualified name of the service.
        request: Request to send.

    Raises:
        UsageError: ``ROS_DOMAIN_ID`` is malformed.
        TeleopctlError: A field of the request has a value that its type cannot hold.
    """

    def __init__(
        self,
        session: zenoh.Session,
        type_: type[ServiceType[RequestT, ResponseT]],
        service: str,
        request: RequestT,
    ) -> None:
        self._service = service
        # For type checkers, a service class is an object whose attributes are classes.
        self._response_type = cast("ServiceType[RequestT, ResponseT]", type_).Response
        self._response: ResponseT | None = None
        self._refused = ""
        # Locks instead of a threading.Event, whose import takes as long as a request. The first
        # caller of _settle acquires `_settling`; `_unsettled` is locked until then.
        self._settling = _thread.allocate_lock()
        self._unsettled = _thread.allocate_lock()
        self._unsettled.acquire()
        name = type_.TYPE_NAME
        send_request(
            session,
            topic_key(domain_id(), service, name, type_hash(name)),
            serialize(request),
            Attachment(_ONLY, time.time_ns(), os.urandom(GID_SIZE)),
            self._receive,
            lambda _: self._settle(),
        )

    def _receive(self, reply: zenoh.Reply) -> None:
        if reply.ok is None:
            return
        try:
            response, _ = read_response(reply.ok, _ONLY, self._response_type)
        except TeleopctlError as error:
            # Another server may send a valid response.
            self._refused = error.message
            return
        if self._response is None:
            self._response = response
        self._settle()

    @transport_callback
    def _settle(self) -> None:
        if self._settling.acquire(blocking=False):
            self._unsettled.release()

    def wait_until_settled(self, timeout_sec: float | None = None) -> bool:
        """Wait for a response or until no server can send one; return False on timeout.

        Args:
            timeout_sec: Longest wait in seconds of wall time; None waits forever.
        """
        settled = self._unsettled.acquire(timeout=-1 if timeout_sec is None else timeout_sec)
        if settled:
            self._unsettled.release()
        return settled

    def wait_for_response(self, timeout_sec: float | None = None) -> ResponseT | None:
        """Wait for the response and return it; None on timeout, an error without a server.

        Args:
            timeout_sec: Longest wait in seconds of wall time; None waits forever.

        Raises:
            UnavailableError: No server responds.
        """
        if self.wait_until_settled(timeout_sec) and self._response is None:
            raise UnavailableError(no_response_text(self._service, self._refused))
        return self._response


class PendingResponse(Protocol[_Response_co]):
    """Interface of sent service requests, to wait for their responses."""

    def wait_for_response(self, timeout_sec: float | None = None) -> _Response_co | None:
        """Wait for the response of a sent request and return it; None on timeout."""


def responses_of_nodes(
    pending: Mapping[str, PendingResponse[ResponseT]], timeout_s: float
) -> dict[str, ResponseT | UnavailableError]:
    """Wait for the responses of several nodes; return a response or an error for each.

    Args:
        pending: Pending response of each node, by full node name.
        timeout_s: Longest wait for all nodes together, in seconds of wall time.

    Returns:
        The response of each node, or an UnavailableError if the node did not respond.
    """
    deadline = time.monotonic() + timeout_s
    return {name: _answer(name, each, deadline, timeout_s) for name, each in pending.items()}


def _answer(
    node: str, pending: PendingResponse[ResponseT], deadline: float, timeout_s: float
) -> ResponseT | UnavailableError:
    try:
        response = pending.wait_for_response(max(0.0, deadline - time.monotonic()))
    except TeleopctlError as error:
        return UnavailableError(f"Node '{node}' did not answer: {error.message}")
    if response is None:
        return UnavailableError(f"Node '{node}' did not answer within {timeout_s:g} s")
    return response

"""Service introspection: events of calls, published on a topic of the service (REP 2012)."""

from __future__ import annotations

import contextlib
import enum

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import get_message
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.values.exceptions import InvalidHandle, RCLError

if TYPE_CHECKING:
    from teleopctl.node.clock import Clock
    from teleopctl.node.endpoints.endpoint import Endpoint
    from teleopctl.node.values.qos import QoSProfile


class ServiceIntrospectionState(enum.IntEnum):
    """Level of service introspection: off, metadata only, or with contents."""

    OFF = 0
    METADATA = 1
    CONTENTS = 2


# Event types of service_msgs/msg/ServiceEventInfo.
_REQUEST_SENT, _REQUEST_RECEIVED, _RESPONSE_SENT, _RESPONSE_RECEIVED = range(4)


class ServiceIntrospection:
    """Publisher of the introspection events of one service client or server.

    Args:
        endpoint: Service client or server.
        service: Service class of the endpoint.
    """

    # Any: a class whose attributes are classes.
    def __init__(self, endpoint: Endpoint, service: Any) -> None:
        self._endpoint = endpoint
        self._service = service
        self._clock: Clock | None = None
        # Any: the event type of the service.
        self._publisher: Publisher[Any] | None = None
        self._state = ServiceIntrospectionState.OFF

    def configure(self, clock: Clock, qos: QoSProfile, state: ServiceIntrospectionState) -> None:
        """Set level and clock; OFF destroys the publisher, other levels create one with the QoS."""
        self._state = ServiceIntrospectionState(state)
        self._clock = clock
        if self._state is ServiceIntrospectionState.OFF:
            self.close()
        elif self._publisher is None:
            self._publisher = Publisher(
                self._endpoint.node,
                self._service.Event,
                f"{self._endpoint.name}/_service_event",
                qos,
            )

    def request_sent(self, client_gid: bytes, sequence: int, request: object) -> None:
        """Publish an event REQUEST_SENT unless OFF, with the request if the level is CONTENTS.

        Args:
            client_gid: GID of the client.
            sequence: Sequence number of the request.
            request: Request message.
        """
        self._publish_event(_REQUEST_SENT, client_gid, sequence, request=request)

    def request_received(self, client_gid: bytes, sequence: int, request: object) -> None:
        """Publish an event REQUEST_RECEIVED, as `request_sent`."""
        self._publish_event(_REQUEST_RECEIVED, client_gid, sequence, request=request)

    def response_sent(self, client_gid: bytes, sequence: int, response: object) -> None:
        """Publish an event RESPONSE_SENT unless OFF, with the response if the level is CONTENTS."""
        self._publish_event(_RESPONSE_SENT, client_gid, sequence, response=response)

    def response_received(self, client_gid: bytes, sequence: int, response: object) -> None:
        """Publish an event RESPONSE_RECEIVED, as `response_sent`."""
        self._publish_event(_RESPONSE_RECEIVED, client_gid, sequence, response=response)

    def _publish_event(
        self,
        event: int,
        client_gid: bytes,
        sequence: int,
        *,
        request: object = None,
        response: object = None,
    ) -> None:
        publisher, clock = self._publisher, self._clock
        if publisher is None or clock is None:
            return
        shows = self._state is ServiceIntrospectionState.CONTENTS
        message = self._service.Event(
            info=get_message("service_msgs/msg/ServiceEventInfo")(
                event_type=event,
                stamp=clock.now().to_msg(),
                client_gid=list(client_gid),
                sequence_number=sequence,
            ),
            request=[request] if shows and request is not None else [],
            response=[response] if shows and response is not None else [],
        )
        # The publisher may have been destroyed in another thread: the call itself continues.
        with contextlib.suppress(InvalidHandle, RCLError):
            publisher.publish(message)

    def close(self) -> None:
        """Destroy the publisher of events, if any. Idempotent."""
        publisher, self._publisher = self._publisher, None
        if publisher is not None:
            publisher.destroy()

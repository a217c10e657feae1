"""What the two ends of a service have in common."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any, NamedTuple
from teleopctl.node.endpoints.endpoint import Endpoint

if TYPE_CHECKING:
    import zenoh

    from teleopctl.node.clock import Clock
    from teleopctl.node.endpoints.service_introspection import (
        ServiceIntrospection,
        ServiceIntrospectionState,
    )
    from teleopctl.node.values.qos import QoSProfile
    from teleopctl.wire import Attachment


class RequestId(NamedTuple):
    """Which request it is: the client's identity, and the number of the request there."""

    writer_guid: bytes
    sequence_number: int


class ServiceInfo(NamedTuple):
    """What is known of a request or a response besides its content; times in ns since the epoch.

    Attributes:
        attachment: As it came.
        received_timestamp: When it came.
        query: What a response answers; None for a response.
    """

    attachment: Attachment
    received_timestamp: int
    query: zenoh.Query | None = None

    @property
    def source_timestamp(self) -> int:
        """When it was sent."""
        return self.attachment.time_ns

    @property
    def request_id(self) -> RequestId:
        """Of the request, also for its response."""
        return RequestId(self.attachment.gid, self.attachment.sequence)


class ServiceEnd(Endpoint):
    """A client or a server of a service.

    Attributes:
        srv_type: The service's class.
    """

    # Any: each end knows which service it is.
    srv_type: Any
    _introspection: ServiceIntrospection | None = None

    def configure_introspection(
        self,
        clock: Clock,
        service_event_qos_profile: QoSProfile,
        introspection_state: ServiceIntrospectionState,
    ) -> None:
        """Publish events of each call on ``SERVICE/_service_event``.

        Args:
            clock: Stamps the events.
            service_event_qos_profile: Quality of service of the publisher, when it is made.
            introspection_state: OFF, METADATA, or CONTENTS: requests and responses besides.
        """
        from teleopctl.node.endpoints.service_introspection import ServiceIntrospection

        self._check_alive()
        if self._introspection is None:
            self._introspection = ServiceIntrospection(self, self.srv_type)
        self._introspection.configure(clock, service_event_qos_profile, introspection_state)

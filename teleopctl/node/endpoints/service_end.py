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
    """Identity of a request: the client's GID and the request's sequence number."""

    writer_guid: bytes
    sequence_number: int


class ServiceInfo(NamedTuple):
    """Metadata of a request or a response; times in nanoseconds since the epoch.

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
        """Time at which the request or response was sent, in nanoseconds since the epoch."""
        return self.attachment.time_ns

    @property
    def request_id(self) -> RequestId:
        """Identity of the request, for a response that of its request."""
        return RequestId(self.attachment.gid, self.attachment.sequence)


class ServiceEnd(Endpoint):
    """Common base of clients and servers of a service.

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
        """Set whether each call is published on ``SERVICE/_service_event``.

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

"""Common base of service servers and clients, and the metadata of calls."""

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
    """Identity of a service request: the client's GID and the sequence number."""

    writer_guid: bytes
    sequence_number: int


class ServiceInfo(NamedTuple):
    """Metadata of a service request or response; times in nanoseconds since the epoch.

    Attributes:
        attachment: Attachment of the Zenoh sample or query.
        received_timestamp: Time of receipt.
        query: Zenoh query to reply to; None for a response.
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
        """Identity of the request; for a response, of the request that it answers."""
        return RequestId(self.attachment.gid, self.attachment.sequence)


class ServiceEndpoint(Endpoint):
    """Common base of service servers and clients, with service introspection.

    Attributes:
        srv_type: Service class.
    """

    # Any: clients and servers declare the service class.
    srv_type: Any
    _introspection: ServiceIntrospection | None = None

    def configure_introspection(
        self,
        clock: Clock,
        service_event_qos_profile: QoSProfile,
        introspection_state: ServiceIntrospectionState,
    ) -> None:
        """Set level, clock and QoS of this endpoint's call events on ``SERVICE/_service_event``.

        Args:
            clock: Clock of the events' stamps.
            service_event_qos_profile: QoS of the publisher, if this call creates the publisher.
            introspection_state: OFF, METADATA, or CONTENTS (with requests and responses).
        """
        from teleopctl.node.endpoints.service_introspection import ServiceIntrospection

        self._check_alive()
        if self._introspection is None:
            self._introspection = ServiceIntrospection(self, self.srv_type)
        self._introspection.configure(clock, service_event_qos_profile, introspection_state)

"""What the graph tells of one endpoint, under the names of ``rclpy.topic_endpoint_info``."""

from __future__ import annotations

import enum
from typing import NamedTuple

from teleopctl.node.values.qos import QoSProfile
from teleopctl.wire import EndpointToken, EntityKind, format_token, gid


class TopicEndpointTypeEnum(enum.IntEnum):
    """Which side of a topic or service an endpoint is."""

    INVALID = 0
    PUBLISHER = 1
    SUBSCRIPTION = 2
    CLIENT = 3
    SERVER = 4


_TYPE_OF_KIND = {
    EntityKind.MP: TopicEndpointTypeEnum.PUBLISHER,
    EntityKind.MS: TopicEndpointTypeEnum.SUBSCRIPTION,
    EntityKind.SC: TopicEndpointTypeEnum.CLIENT,
    EntityKind.SS: TopicEndpointTypeEnum.SERVER,
}


class TopicEndpointInfo(NamedTuple):
    """One publisher, subscription, client or server, as its liveliness token announces it.

    Attributes:
        node_name: Name of the node that owns it.
        node_namespace: Namespace of that node.
        topic_type: Such as ``std_msgs/msg/String``.
        topic_type_hash: Such as ``RIHS01_…``.
        endpoint_type: Which side it is.
        endpoint_gid: The 16 bytes that identify it.
        qos_profile: Its quality of service.
    """

    node_name: str
    node_namespace: str
    topic_type: str
    topic_type_hash: str
    endpoint_type: TopicEndpointTypeEnum
    endpoint_gid: list[int]
    qos_profile: QoSProfile

    @classmethod
    def of(cls, token: EndpointToken) -> TopicEndpointInfo:
        """Return what a token tells."""
        return cls(
            node_name=token.node,
            node_namespace=token.namespace,
            topic_type=token.type_name,
            topic_type_hash=token.type_hash,
            endpoint_type=_TYPE_OF_KIND[token.kind],
            endpoint_gid=list(gid(format_token(token))),
            qos_profile=QoSProfile.from_wire(token.qos),
        )

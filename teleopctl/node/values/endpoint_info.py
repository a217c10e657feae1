"""Endpoints of the graph: owner, type hash and QoS, as ``rclpy.topic_endpoint_info`` has them."""

from __future__ import annotations

import enum
from collections.abc import Sequence

from teleopctl.node.values.qos import HistoryPolicy, QoSProfile, qos_profile_unknown
from teleopctl.wire import EndpointToken, EntityKind, format_token, gid

_SIZE = 32


class TypeHash:
    """Version and value of the hash of a type's definition.

    Args:
        version: Version of the hash algorithm; 1 for RIHS01.
        value: The 32 bytes of the hash.
    """

    __slots__ = ("value", "version")

    def __init__(self, version: int = -1, value: bytes = bytes(_SIZE)) -> None:
        self.version = version
        self.value = value

    @classmethod
    def from_text(cls, text: str) -> TypeHash:
        """Return the hash in a text such as ``RIHS01_…``; an invalid one if malformed."""
        version, _, digits = text.removeprefix("RIHS").partition("_")
        try:
            return cls(int(version), bytes.fromhex(digits))
        except ValueError:
            return cls()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TypeHash):
            return NotImplemented
        return (self.version, self.value) == (other.version, other.value)

    def __hash__(self) -> int:
        return hash((self.version, self.value))

    def __str__(self) -> str:
        if self.version <= 0 or len(self.value) != _SIZE:
            return "INVALID"
        return f"RIHS{self.version:02}_{self.value.hex()}"

    def __repr__(self) -> str:
        return f"TypeHash({self})"


class TopicEndpointTypeEnum(enum.IntEnum):
    """Kind of an endpoint: publisher, subscription, client or server."""

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


class TopicEndpointInfo:
    """Description of a publisher, subscription, server or client of the graph.

    Args:
        node_name: Name of the node of the endpoint.
        node_namespace: Namespace of that node.
        topic_type: ROS name of the type, such as ``std_msgs/msg/String``.
        topic_type_hash: Hash of that type.
        endpoint_type: Kind of the endpoint.
        endpoint_gid: GID of the endpoint, 16 bytes.
        qos_profile: QoS profile of the endpoint.
    """

    __slots__ = (
        "endpoint_gid",
        "endpoint_type",
        "node_name",
        "node_namespace",
        "qos_profile",
        "topic_type",
        "topic_type_hash",
    )

    def __init__(
        self,
        *,
        node_name: str = "",
        node_namespace: str = "",
        topic_type: str = "",
        topic_type_hash: TypeHash | None = None,
        endpoint_type: TopicEndpointTypeEnum | int = TopicEndpointTypeEnum.INVALID,
        endpoint_gid: Sequence[int] = (),
        qos_profile: QoSProfile | None = None,
    ) -> None:
        self.node_name = node_name
        self.node_namespace = node_namespace
        self.topic_type = topic_type
        self.topic_type_hash = TypeHash() if topic_type_hash is None else topic_type_hash
        self.endpoint_type = TopicEndpointTypeEnum(endpoint_type)
        self.endpoint_gid = list(endpoint_gid)
        self.qos_profile = qos_profile_unknown if qos_profile is None else qos_profile

    @classmethod
    def of(cls, token: EndpointToken) -> TopicEndpointInfo:
        """Return the description in an endpoint's liveliness token."""
        return cls(
            node_name=token.node,
            node_namespace=token.namespace,
            topic_type=token.type_name,
            topic_type_hash=TypeHash.from_text(token.type_hash),
            endpoint_type=_TYPE_OF_KIND[token.kind],
            endpoint_gid=gid(format_token(token)),
            qos_profile=QoSProfile.from_wire(token.qos),
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TopicEndpointInfo):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in self.__slots__)

    __hash__ = None  # type: ignore[assignment]  # mutable

    def __str__(self) -> str:
        qos = self.qos_profile
        depth = f" ({qos.depth})" if qos.history == HistoryPolicy.KEEP_LAST else ""
        return "\n".join(
            [
                f"Node name: {self.node_name}",
                f"Node namespace: {self.node_namespace}",
                f"Topic type: {self.topic_type}",
                f"Topic type hash: {self.topic_type_hash}",
                f"Endpoint type: {self.endpoint_type.name}",
                f"GID: {'.'.join(f'{byte:02x}' for byte in self.endpoint_gid)}",
                "QoS profile:",
                f"  Reliability: {qos.reliability.name}",
                f"  History (Depth): {qos.history.name}{depth}",
                f"  Durability: {qos.durability.name}",
                f"  Lifespan: {qos.lifespan}",
                f"  Deadline: {qos.deadline}",
                f"  Liveliness: {qos.liveliness.name}",
                f"  Liveliness lease duration: {qos.liveliness_lease_duration}",
            ]
        )

"""Subscriptions to topics of any type: serialized messages, matching QoS, unknown types."""

from __future__ import annotations

import time
from collections.abc import Sequence

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import add_description, get_service, known_types
from teleopctl.node.values.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

if TYPE_CHECKING:
    from type_description_interfaces.msg import TypeDescription

    from teleopctl.node.endpoints.subscription import RawCallback, Subscription
    from teleopctl.node.node_endpoints import NodeEndpoints
    from teleopctl.wire import EndpointQos, Graph

_DESCRIBES_TYPES = "type_description_interfaces/srv/GetTypeDescription"
_DESCRIBE = "get_type_description"
_WAIT_FOR_ONE_S = 2.0


def raw_message_class(type_name: str, version: str) -> type[Any]:  # Any: stands for any type
    """Return a message class with a type's name and hash but no fields, for raw subscriptions.

    Args:
        type_name: Full name of the type.
        version: Hash of the type, as in its publishers' liveliness tokens.
    """
    return type("RawMessage", (), {"TYPE_NAME": type_name, "TYPE_HASH": version})


def qos_for_publishers(publishers_qos: Sequence[EndpointQos], depth: int) -> QoSProfile:
    """Return the strictest QoS (reliability, durability) that fits all of a topic's publishers.

    Reliable if all publishers are, transient local if all are; reliable and volatile without any.
    """
    reliable = all(qos.is_reliable for qos in publishers_qos)
    latched = bool(publishers_qos) and all(qos.is_transient_local for qos in publishers_qos)
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=(DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE),
    )


def create_generic_subscription(
    node: NodeEndpoints,
    topic: str,
    type_name: str,
    callback: RawCallback,
    *,
    qos: QoSProfile | None = None,
    depth: int = 10,
) -> Subscription[Any]:  # Any: of any type
    """Return a new subscription whose callback gets messages as CDR bytes, on Zenoh's thread.

    Args:
        node: Node of the subscription.
        topic: Fully qualified name of the topic.
        type_name: ROS name of the topic's type.
        callback: Called with the CDR bytes of each message on Zenoh's thread, so it must be short;
            see `Subscription`.
        qos: QoS profile; `qos_for_publishers` of the topic's present publishers if None.
        depth: History depth if ``qos`` is None.
    """
    publishers = node.graph().publishers(topic, type_name)
    if publishers:
        message_class = raw_message_class(type_name, publishers[0].type_hash)
    else:
        from teleopctl.interfaces import type_hash

        message_class = raw_message_class(type_name, type_hash(type_name))
    qos = qos or qos_for_publishers([publisher.qos for publisher in publishers], depth)
    return node.create_subscription(message_class, topic, callback, qos, raw=True, immediate=True)


def add_type_from_graph(
    node: NodeEndpoints, type_name: str, graph: Graph, longest_s: float = 5.0
) -> None:
    """Request an unknown type's description from nodes that use the type, and register the type.

    The type stays unknown if no node serves its description.

    Args:
        node: The node that sends the request; it needs no executor.
        type_name: Full name of a message or a service.
        graph: Snapshot of the graph, with the nodes that use the type.
        longest_s: Longest wait in seconds of wall time.

    Raises:
        InvalidMessageError: The description is malformed, or contradicts a known type.
    """
    if known_types().find(type_name) is not None:
        return
    # Hash of the type that each node uses.
    versions = {e.full_name: e.type_hash for e in graph.endpoints if e.type_name == type_name}
    deadline = time.monotonic() + longest_s
    for name, version in versions.items():
        timeout_s = min(_WAIT_FOR_ONE_S, deadline - time.monotonic())
        if not graph.servers(f"{name}/{_DESCRIBE}") or timeout_s <= 0:
            continue
        description = request_type_description(node, name, type_name, version, timeout_s)
        if description is not None:
            add_description(description)
            return


def request_type_description(
    node: NodeEndpoints,
    node_name: str,
    type_name: str,
    version: str,
    longest_s: float = _WAIT_FOR_ONE_S,
) -> TypeDescription | None:
    """Request a type's description from a node, wait, and return it; None on refusal or timeout.

    Args:
        node: The node that sends the request; it needs no executor.
        node_name: Full name of the node that serves the description.
        type_name: Full name of the type.
        version: Hash of the type that the node uses.
        longest_s: Longest wait in seconds of wall time.
    """
    service_class = get_service(_DESCRIBES_TYPES)
    request = service_class.Request(
        type_name=type_name, type_hash=version, include_type_sources=False
    )
    client = node.create_client(service_class, f"{node_name}/{_DESCRIBE}")
    try:
        answer = client.call_async(request).wait_for_response(longest_s)
    finally:
        node.destroy_client(client)
    if answer is None or not answer.successful:
        return None
    description: TypeDescription = answer.type_description
    return description if description.type_description.type_name == type_name else None

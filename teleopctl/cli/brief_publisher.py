"""A publisher of one message, put together from the wire's parts without a node of the library.

``topic pub --once`` spends most of its time on imports; the library's node takes half of them.
"""

from __future__ import annotations

import time

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Self
from teleopctl.interfaces import type_hash
from teleopctl.node.values.names import expand_name, validate_node_name
from teleopctl.wire import (
    EndpointQos,
    EndpointToken,
    EntityKind,
    NodeToken,
    domain_id,
    encode_attachment,
    format_token,
    gid,
    open_session,
    query_graph,
    topic_key,
)

if TYPE_CHECKING:
    from teleopctl.wire import Graph

_ENCLAVE = _NAMESPACE = "/"
_NODE_ID, _PUBLISHER_ID = 0, 1


class BriefPublisher:
    """Reliable, volatile publisher of one message, by a client of the router.

    In the graph, node and publisher stand as those of any ROS 2 program. Use it as a context
    manager: the session is closed at the end.

    Args:
        node_name: Name of its node, in the root namespace.
        topic: Name of the topic, which is expanded against the node.
        type_name: Type, such as ``std_msgs/msg/String``.
        depth: Number of messages that a subscriber may keep, in its QoS.

    Attributes:
        topic: Full name of the topic.
        session: The Zenoh session.

    Raises:
        NameValidationException: A name breaks a rule.
        RouterNotRunning: No router runs.
    """

    def __init__(self, node_name: str, topic: str, type_name: str, depth: int) -> None:
        validate_node_name(node_name)
        self.topic = expand_name(topic, node_name, _NAMESPACE, is_service=False)
        self._node_name = node_name
        self._type_name = type_name
        self._depth = depth
        self.session = open_session("client")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.session.close()

    def graph(self) -> Graph:
        """Return the graph as the router has it now."""
        return query_graph(self.session)

    def publish(self, payload: bytes | bytearray) -> None:
        """Announce node and publisher, and send the message, as CDR bytes."""
        domain, zid = domain_id(), str(self.session.zid())
        version = type_hash(self._type_name)
        publisher = format_token(
            EndpointToken(
                domain=domain,
                zid=zid,
                nid=_NODE_ID,
                eid=_PUBLISHER_ID,
                kind=EntityKind.MP,
                enclave=_ENCLAVE,
                namespace=_NAMESPACE,
                node=self._node_name,
                name=self.topic,
                type_name=self._type_name,
                type_hash=version,
                qos=EndpointQos(depth=self._depth),
            )
        )
        node = NodeToken(domain, zid, _NODE_ID, _ENCLAVE, _NAMESPACE, self._node_name)
        channel = self.session.declare_publisher(
            topic_key(domain, self.topic, self._type_name, version),
            reliability=zenoh.Reliability.RELIABLE,
            congestion_control=zenoh.CongestionControl.DROP,
        )
        declare = self.session.liveliness().declare_token
        # A token that nothing refers to any more is undeclared.
        self._tokens = declare(format_token(node)), declare(publisher)
        channel.put(payload, attachment=encode_attachment(1, time.time_ns(), gid(publisher)))

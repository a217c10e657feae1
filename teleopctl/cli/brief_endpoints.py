"""A publisher or a subscription for one message, put together from the wire's parts alone.

``topic pub --once`` and ``topic echo --once`` spend most of their time on imports, and a node of
the client library would take half of them. In the graph, node and endpoint stand as those of any
ROS 2 program.
"""

from __future__ import annotations

import time
from _thread import allocate_lock  # threading has more, which takes milliseconds to import

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Any, Iterator, Self, suppress
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import deserialize, type_hash
from teleopctl.node import expand_name, validate_node_name
from teleopctl.wire import (
    EndpointQos,
    EndpointToken,
    EntityKind,
    NodeToken,
    decode_attachment,
    direct_callback,
    domain_id,
    encode_attachment,
    format_token,
    gid,
    open_session,
    query_graph,
    topic_key,
)

if TYPE_CHECKING:
    from teleopctl.node import MessageInfo
    from teleopctl.wire import Graph, InvalidMessageCounter

_ENCLAVE = _NAMESPACE = "/"
_NODE_ID, _ENDPOINT_ID = 0, 1
# Interval at which a wait notices Ctrl-C on Windows.
_LOOK_EVERY_S = 0.2


class BriefNode:
    """Hidden node of a command with at most one endpoint, connected as a client of the router.

    Use it as a context manager: the session is closed at the end.

    Args:
        name: Name of the node, in the root namespace.

    Attributes:
        session: The Zenoh session.

    Raises:
        InvalidNodeNameException: The name breaks a rule.
        RouterNotRunning: No router runs.
    """

    def __init__(self, name: str) -> None:
        validate_node_name(name)
        self._name = name
        self.session = open_session("client")
        self._tokens: list[zenoh.LivelinessToken] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.session.close()

    def graph(self) -> Graph:
        """Return the graph as it is now."""
        return query_graph(self.session)

    def resolve_topic_name(self, topic: str) -> str:
        """Return the full name of a topic.

        Raises:
            InvalidTopicNameException: The name breaks a rule.
        """
        return expand_name(topic, self._name, _NAMESPACE, is_service=False)

    def publish(
        self, topic: str, type_name: str, payload: bytes | bytearray, qos: EndpointQos
    ) -> None:
        """Announce the node and a reliable, volatile publisher, and send its message.

        Args:
            topic: Full name of the topic.
            type_name: Type, such as ``std_msgs/msg/String``.
            payload: The message as CDR.
            qos: QoS that the publisher offers.
        """
        channel = self.session.declare_publisher(
            topic_key(domain_id(), topic, type_name, type_hash(type_name)),
            reliability=zenoh.Reliability.RELIABLE,
            congestion_control=zenoh.CongestionControl.DROP,
        )
        token = self._announce(EntityKind.MP, topic, type_name, qos)
        channel.put(payload, attachment=encode_attachment(1, time.time_ns(), gid(token)))

    # Any: a class of messages, and messages of it.
    def receive(
        self,
        topic: str,
        message_class: type[Any],
        qos: EndpointQos,
        report: InvalidMessageCounter,
        timeout_s: float | None,
    ) -> Iterator[tuple[Any, MessageInfo]]:
        """Announce the node and a volatile subscription, and yield its messages until a timeout.

        Args:
            topic: Full name of the topic.
            message_class: Class of the messages.
            qos: QoS that the subscription requests.
            report: Counter of malformed messages, which are left out.
            timeout_s: Longest wait for all messages, in seconds; None for no limit.
        """
        arrived: list[tuple[zenoh.Sample, int]] = []
        # Held while nothing waits to be taken.
        nothing = allocate_lock()
        nothing.acquire()

        def add(sample: zenoh.Sample) -> None:
            arrived.append((sample, time.time_ns()))
            if nothing.locked():
                # Another thread of Zenoh may have been faster.
                with suppress(RuntimeError):
                    nothing.release()

        type_name: str = message_class.TYPE_NAME
        key = topic_key(domain_id(), topic, type_name, type_hash(type_name))
        # Zenoh keeps no subscriber that nothing refers to.
        subscriber = self.session.declare_subscriber(key, direct_callback(add))
        self._announce(EntityKind.MS, topic, type_name, qos)
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        try:
            while end_s is None or time.monotonic() < end_s:
                left_s = _LOOK_EVERY_S if end_s is None else end_s - time.monotonic()
                if not nothing.acquire(timeout=max(0.0, min(left_s, _LOOK_EVERY_S))):
                    continue
                # A message that arrives from now on releases the lock again.
                while arrived:
                    taken = _decoded(*arrived.pop(0), message_class, report)
                    if taken is not None:
                        yield taken
        finally:
            subscriber.undeclare()

    def _announce(self, kind: EntityKind, topic: str, type_name: str, qos: EndpointQos) -> str:
        """Declare the tokens of node and endpoint, and return that of the endpoint."""
        domain, zid = domain_id(), str(self.session.zid())
        endpoint = format_token(
            EndpointToken(
                domain=domain,
                zid=zid,
                nid=_NODE_ID,
                eid=_ENDPOINT_ID,
                kind=kind,
                enclave=_ENCLAVE,
                namespace=_NAMESPACE,
                node=self._name,
                name=topic,
                type_name=type_name,
                type_hash=type_hash(type_name),
                qos=qos,
            )
        )
        node = NodeToken(domain, zid, _NODE_ID, _ENCLAVE, _NAMESPACE, self._name)
        declare = self.session.liveliness().declare_token
        # A token that nothing refers to any more is undeclared.
        self._tokens = [declare(format_token(node)), declare(endpoint)]
        return endpoint


# Any: as above.
def _decoded(
    sample: zenoh.Sample, received_ns: int, message_class: type[Any], report: InvalidMessageCounter
) -> tuple[Any, MessageInfo] | None:
    """Return a sample's message and metadata; count it and return None if it is malformed."""
    try:
        message = deserialize(sample.payload.to_bytes(), message_class)
    except TeleopctlError as error:
        report.refuse(error.message)
        return None
    meta = decode_attachment(sample.attachment.to_bytes()) if sample.attachment else None
    if meta is None:
        report.refuse("it came without a readable attachment")
        return None
    return message, {
        "source_timestamp": meta.time_ns,
        "received_timestamp": received_ns,
        "publication_sequence_number": meta.sequence,
        "reception_sequence_number": 0,  # as under rmw_zenoh, which does not count them
        "publisher_gid": meta.gid,
    }

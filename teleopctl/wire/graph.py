"""Snapshot of the ROS graph of a domain, made from its liveliness tokens.

Nothing is stored or cached between processes: `query_graph` sends one query, a
`GraphWatcher` follows the changes. Both return a `Graph`, a snapshot with the queries of ROS's
graph API as methods.
"""

from __future__ import annotations

import zenoh

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.wire.keys import LIVELINESS_PREFIX, liveliness_key
from teleopctl.wire.session import domain_id, is_client
from teleopctl.wire.tokens import (
    EndpointToken,
    EntityKind,
    NodeToken,
    endpoint_tokens_key,
    join_name,
    parse_token,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

# An action appears in the graph by its feedback topic, which server and clients have.
_FEEDBACK_TOPIC = "/_action/feedback"
_FEEDBACK_TYPE = "_FeedbackMessage"

MOST_TOKENS = 100_000
"""Largest number of tokens in a graph: ten times that of a large fleet, in 100 MB."""

# A key below the prefix of all tokens, at which no token is declared.
_NOTHING = f"{LIVELINESS_PREFIX}/nobody"

_NodeKey = tuple[str, str, str, int]


def is_hidden_name(name: str) -> bool:
    """Return whether a topic or service is hidden: a part of its name starts with ``_``."""
    return "/_" in name or name.startswith("_")


def action_type(endpoint: EndpointToken) -> str | None:
    """Return the action type that a feedback endpoint belongs to; None for other endpoints."""
    if endpoint.name.endswith(_FEEDBACK_TOPIC) and endpoint.type_name.endswith(_FEEDBACK_TYPE):
        return endpoint.type_name.removesuffix(_FEEDBACK_TYPE)
    return None


def actions_of(endpoints: Iterable[EndpointToken]) -> list[tuple[str, list[str]]]:
    """Return name and types of each action that has feedback endpoints among the given ones.

    As in rcl_action, only feedback topics are considered.
    """
    types: dict[str, set[str]] = {}
    for endpoint in endpoints:
        if (kind := action_type(endpoint)) is not None:
            types.setdefault(endpoint.name.removesuffix(_FEEDBACK_TOPIC), set()).add(kind)
    return [(name, sorted(types[name])) for name in sorted(types)]


class NodeEntry:
    """Node of the graph, with its publishers, subscriptions, servers and clients as tokens."""

    __slots__ = ("enclave", "endpoints", "name", "namespace", "nid", "zid")

    def __init__(self, token: NodeToken | EndpointToken) -> None:
        self.name = token.node
        self.namespace = token.namespace
        self.enclave = token.enclave
        self.zid = token.zid
        self.nid = token.nid
        self.endpoints: list[EndpointToken] = []

    @property
    def full_name(self) -> str:
        """Namespace and name of the node, such as ``/ns/node``."""
        return join_name(self.namespace, self.name)

    @property
    def is_hidden(self) -> bool:
        """Whether the node is hidden: its name starts with ``_``."""
        return self.name.startswith("_")

    def of_kind(self, kind: EntityKind) -> list[EndpointToken]:
        """Return the node's endpoints of one kind, sorted by name."""
        return sorted((e for e in self.endpoints if e.kind is kind), key=_by_name)


class Graph:
    """Immutable snapshot of the nodes, topics and services of a ROS domain.

    Attributes:
        nodes: One entry for each namespace, name, session and ID, so that a name that two processes
            use occurs twice.
        endpoints: Every publisher, subscription, service server and service client.

    Example:
        >>> graph = next(watch_graph())
        >>> graph.node_names()
        ['/talker']
        >>> dict(graph.topic_names_and_types())["/chatter"]
        ['std_msgs/msg/String']
    """

    __slots__ = ("_by_kind", "endpoints", "nodes")

    def __init__(self, tokens: Iterable[NodeToken | EndpointToken] = ()) -> None:
        nodes: dict[_NodeKey, NodeEntry] = {}
        endpoints: list[EndpointToken] = []
        by_kind: dict[EntityKind, dict[str, list[EndpointToken]]] = {k: {} for k in EntityKind}
        for token in tokens:
            key = node_key(token)
            # Tokens arrive in any order: an endpoint's token may precede that of its node.
            node = nodes.get(key)
            if node is None:
                node = nodes[key] = NodeEntry(token)
            if isinstance(token, EndpointToken):
                node.endpoints.append(token)
                endpoints.append(token)
                by_kind[token.kind].setdefault(token.name, []).append(token)
        self.nodes: tuple[NodeEntry, ...] = tuple(nodes.values())
        self.endpoints: tuple[EndpointToken, ...] = tuple(endpoints)
        self._by_kind = by_kind

    def node_names(self, include_hidden: bool = False) -> list[str]:
        """Return sorted full names of nodes with duplicates; hidden ones with `include_hidden`."""
        return sorted(n.full_name for n in self.nodes if include_hidden or not n.is_hidden)

    def find_node(self, full_name: str) -> NodeEntry | None:
        """Return the first node with a full name (``/ns/node``), or None."""
        return next((n for n in self.nodes if n.full_name == full_name), None)

    def topic_names_and_types(self, include_hidden: bool = False) -> list[tuple[str, list[str]]]:
        """Return all topics with their types, sorted; hidden ones only with `include_hidden`."""
        return self._names_and_types((EntityKind.MP, EntityKind.MS), include_hidden)

    def service_names_and_types(self, include_hidden: bool = False) -> list[tuple[str, list[str]]]:
        """Return all services with their types, sorted; hidden ones only with `include_hidden`."""
        return self._names_and_types((EntityKind.SS, EntityKind.SC), include_hidden)

    def action_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return all actions with their types, sorted."""
        return actions_of(e for e in self.endpoints if e.kind in (EntityKind.MP, EntityKind.MS))

    def action_servers(self, action: str) -> list[EndpointToken]:
        """Return the feedback publishers of an action (``/ns/action``): one per server."""
        return self._of_action(EntityKind.MP, action)

    def action_clients(self, action: str) -> list[EndpointToken]:
        """Return the feedback subscriptions of an action (``/ns/action``): one per client."""
        return self._of_action(EntityKind.MS, action)

    def publishers(self, topic: str, type_name: str | None = None) -> list[EndpointToken]:
        """Return the publishers of a topic (``/ns/topic``), optionally of one type."""
        return self._of(EntityKind.MP, topic, type_name)

    def subscriptions(self, topic: str, type_name: str | None = None) -> list[EndpointToken]:
        """Return the subscriptions of a topic, optionally of one type."""
        return self._of(EntityKind.MS, topic, type_name)

    def servers(self, service: str, type_name: str | None = None) -> list[EndpointToken]:
        """Return the servers of a service, optionally of one type."""
        return self._of(EntityKind.SS, service, type_name)

    def clients(self, service: str, type_name: str | None = None) -> list[EndpointToken]:
        """Return the clients of a service, optionally of one type."""
        return self._of(EntityKind.SC, service, type_name)

    def _of(self, kind: EntityKind, name: str, type_name: str | None) -> list[EndpointToken]:
        found = self._by_kind[kind].get(name, [])
        return [e for e in found if type_name is None or e.type_name == type_name]

    def _of_action(self, kind: EntityKind, action: str) -> list[EndpointToken]:
        found = self._by_kind[kind].get(f"{action}{_FEEDBACK_TOPIC}", [])
        return [e for e in found if action_type(e) is not None]

    def _names_and_types(
        self, kinds: tuple[EntityKind, ...], include_hidden: bool
    ) -> list[tuple[str, list[str]]]:
        types: dict[str, set[str]] = {}
        for kind in kinds:
            for name, endpoints in self._by_kind[kind].items():
                if include_hidden or not is_hidden_name(name):
                    types.setdefault(name, set()).update(e.type_name for e in endpoints)
        return [(name, sorted(types[name])) for name in sorted(types)]


def query_graph(session: zenoh.Session, domain: int | None = None, timeout_s: float = 5.0) -> Graph:
    """Query the liveliness tokens of a domain once, and return the ROS graph made from them.

    Not for a session with a `GraphWatcher`, which has the graph: there Zenoh 1.10 sometimes omits
    tokens from a reply.

    Args:
        session: Zenoh session. A client receives all tokens of the router; a peer, those of the
            peers that it is connected to.
        domain: ROS domain, by default that of ``ROS_DOMAIN_ID``.
        timeout_s: Longest wait in seconds; normally the replies take a millisecond.
    """
    return _query(session, liveliness_key(domain_id() if domain is None else domain), timeout_s)


def query_endpoints(session: zenoh.Session, name: str) -> Graph:
    """Return the part of the ROS graph with the endpoints of a topic or service.

    Its nodes have these endpoints alone. In a large graph, `query_graph` takes far longer.

    Args:
        session: Zenoh session; see `query_graph`.
        name: Fully qualified name of the topic or service.
    """
    key = endpoint_tokens_key(domain_id(), name)
    return Graph() if key is None else _query(session, key)


def _query(session: zenoh.Session, key: str, timeout_s: float = 5.0) -> Graph:
    liveliness = session.liveliness()
    if is_client(session):
        replies = liveliness.get(key, zenoh.handlers.FifoChannel(MOST_TOKENS), timeout=timeout_s)
        return Graph(_tokens(reply.ok for reply in replies if reply.ok is not None))
    # In a peer, Zenoh 1.10 reports the end of a query on another thread, often before all replies,
    # and the rest is lost. So a subscriber receives the tokens, and then a query for a key without
    # tokens is sent: a peer that has replied to it has sent all of its tokens. Zenoh delivers known
    # tokens on the declaring thread, so a full channel that blocks would wait forever: this one
    # drops the oldest.
    with liveliness.declare_subscriber(
        key, zenoh.handlers.RingChannel(MOST_TOKENS), history=True
    ) as subscriber:
        for _ in liveliness.get(_NOTHING, timeout=timeout_s):
            pass
        samples: list[zenoh.Sample] = []
        while (sample := subscriber.try_recv()) is not None:
            samples.append(sample)
    return Graph(_tokens(samples))


def _tokens(samples: Iterable[zenoh.Sample]) -> Iterator[NodeToken | EndpointToken]:
    """Parsed tokens that exist after all samples, each once."""
    there: dict[str, NodeToken | EndpointToken | None] = {}
    for sample in samples:
        text = str(sample.key_expr)
        if sample.kind == zenoh.SampleKind.DELETE:
            there.pop(text, None)
        elif text not in there:
            there[text] = parse_token(text)
    return (token for token in there.values() if token is not None)


def node_key(token: NodeToken | EndpointToken) -> _NodeKey:
    """Return the key that identifies a token's node: namespace, name, session id and node id."""
    return (token.namespace, token.node, token.zid, token.nid)


def _by_name(endpoint: EndpointToken) -> str:
    return endpoint.name

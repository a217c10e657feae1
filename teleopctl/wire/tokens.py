"""Liveliness tokens, by which nodes and endpoints are visible in the ROS graph.

Every node, publisher, subscription, service server and service client declares one token, whose
key contains all information of the ROS graph about it. Names and types are stored in their ROS form
(``/robot1/chatter``, ``std_msgs/msg/String``) and mangled only in the key.
"""

from __future__ import annotations

from teleopctl.base.printable import printable_line
from teleopctl.base.typed import NamedTuple, StrEnum
from teleopctl.interfaces import from_dds, to_dds
from teleopctl.wire.keys import LIVELINESS_PREFIX, parse_decimal
from teleopctl.wire.qos import EndpointQos, format_qos, parse_qos

_BACKENDS = "backends:"
_NODE_CHUNKS = 9
_ENDPOINT_CHUNKS = 13
_LONGEST_TOKEN = 8192
# Characters that Zenoh forbids in a key or reads as a wildcard, and the separator of chunks.
_FORBIDDEN = frozenset("/#?$*")


class EntityKind(StrEnum):
    """Kind of an entity in liveliness tokens: node, publisher, subscription, server or client."""

    NN = "NN"
    MP = "MP"
    MS = "MS"
    SS = "SS"
    SC = "SC"


class NodeToken(NamedTuple):
    """Liveliness token of a node, parsed.

    ``text`` is the token as it was received; it is empty in a token that was not parsed.
    """

    domain: int
    zid: str
    nid: int
    enclave: str
    namespace: str
    node: str
    text: str = ""

    @property
    def full_name(self) -> str:
        """Full name of the node, such as ``/ns/node``."""
        return join_name(self.namespace, self.node)


class EndpointToken(NamedTuple):
    """Liveliness token of a publisher, subscription, server or client, parsed.

    ``backends`` is the list of buffer backends that ROS 2 Lyrical appends for some message types
    (``cpu:``), None elsewhere. ``text`` is the token as it was received; it is empty in a token
    that was not parsed.
    """

    domain: int
    zid: str
    nid: int
    eid: int
    kind: EntityKind
    enclave: str
    namespace: str
    node: str
    name: str
    type_name: str
    type_hash: str
    qos: EndpointQos
    backends: str | None = None
    text: str = ""

    @property
    def full_name(self) -> str:
        """Full name of the endpoint's node, such as ``/ns/node``."""
        return join_name(self.namespace, self.node)

    @property
    def gid(self) -> bytes:
        """GID of the endpoint, 16 bytes, computed from the token's text."""
        return gid(self.text or format_token(self))


def join_name(namespace: str, name: str) -> str:
    """Return the full name of a node: ``/`` and ``talker`` give ``/talker``."""
    return f"{namespace.rstrip('/')}/{name}"


def format_token(token: NodeToken | EndpointToken) -> str:
    """Return a liveliness token as the key expression that Zenoh declares.

    Raises:
        ValueError: A part is empty or contains a character that is invalid in a Zenoh key, so that
            receivers would reject or misread the token.
    """
    endpoint = token if isinstance(token, EndpointToken) else None
    chunks = [
        LIVELINESS_PREFIX,
        str(token.domain),
        token.zid,
        str(token.nid),
        str(endpoint.eid if endpoint else token.nid),
        endpoint.kind.value if endpoint else EntityKind.NN.value,
        _mangle(token.enclave),
        _mangle(token.namespace),
        token.node,
    ]
    if endpoint is not None:
        chunks += [
            _mangle(endpoint.name),
            to_dds(endpoint.type_name),
            endpoint.type_hash,
            format_qos(endpoint.qos),
        ]
        if endpoint.backends is not None:
            chunks.append(_BACKENDS + endpoint.backends)
    for chunk in chunks:
        if not chunk or not _FORBIDDEN.isdisjoint(chunk):
            raise ValueError(f"{chunk!r} cannot be a part of a liveliness token")
    return "/".join(chunks)


def endpoint_tokens_key(domain: int, name: str) -> str | None:
    """Return the key expression of the tokens of a topic's or service's endpoints.

    None for a name that no key can contain, and so no token.
    """
    chunk = _mangle(name)
    if not chunk or not _FORBIDDEN.isdisjoint(chunk):
        return None
    # Any session, node ID, endpoint ID, kind, enclave, namespace and node.
    return f"{LIVELINESS_PREFIX}/{domain}/*/*/*/*/*/*/*/{chunk}/**"


def parse_token(text: str) -> NodeToken | EndpointToken | None:
    r"""Parse the key expression of a liveliness token to a token; return None if malformed.

    Tokens come from other processes, so size and form are checked. Control characters, which no
    name of ROS has, are escaped in all fields (``\x1b``) except ``text``, the token as received.
    """
    if len(text) > _LONGEST_TOKEN:
        return None
    # Escaped once here, so that every program can print the names.
    chunks = printable_line(text).split("/")
    if len(chunks) < _NODE_CHUNKS or chunks[0] != LIVELINESS_PREFIX or "" in chunks:
        return None
    domain, nid, eid = parse_decimal(chunks[1]), parse_decimal(chunks[3]), parse_decimal(chunks[4])
    if domain is None or nid is None or eid is None:
        return None
    zid, kind = chunks[2], _KINDS.get(chunks[5])
    enclave, namespace, node = _demangle(chunks[6]), _demangle(chunks[7]), chunks[8]
    if kind is EntityKind.NN:
        return NodeToken(domain, zid, nid, enclave, namespace, node, text)
    if kind is None or len(chunks) < _ENDPOINT_CHUNKS:
        return None
    qos = parse_qos(chunks[12])
    if qos is None:
        return None
    backends = None
    if len(chunks) > _ENDPOINT_CHUNKS and chunks[13].startswith(_BACKENDS):
        backends = chunks[13].removeprefix(_BACKENDS)
    return EndpointToken(
        domain,
        zid,
        nid,
        eid,
        kind,
        enclave,
        namespace,
        node,
        _demangle(chunks[9]),
        from_dds(chunks[10]),
        chunks[11],
        qos,
        backends,
        text,
    )


def gid(token_text: str) -> bytes:
    """Return the GID, 16 bytes, of the endpoint that has this liveliness token."""
    # Imported here: only publishers and verbose listings need the hash.
    import xxhash

    return xxhash.xxh3_128_digest(token_text.encode())[::-1]


_KINDS = {kind.value: kind for kind in EntityKind}


def _mangle(name: str) -> str:
    return name.replace("/", "%")


def _demangle(text: str) -> str:
    return text.replace("%", "/")

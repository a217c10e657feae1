"""Addresses of routers: endpoints at which sessions look for one and the daemon listens.

A session connects to ``connect/endpoints`` of the session configuration. A router listens on
``listen/endpoints`` of the router configuration, whose ``connect/endpoints`` name other routers.
Both addresses are equal unless a configuration file or ``ZENOH_CONFIG_OVERRIDE`` changes one.
"""

from __future__ import annotations

from teleopctl.base.typed import Iterable
from teleopctl.wire.keys import parse_decimal

DEFAULT_ENDPOINT = "tcp/localhost:7447"

_LARGEST_PORT = 2**16 - 1
_LOOPBACK = ("localhost", "[::1]")
_PROTOCOLS_WITH_PORTS = ("tcp", "tls", "udp", "quic", "ws")
_WILDCARDS = {"[::]": "localhost", "0.0.0.0": "127.0.0.1"}  # noqa: S104 (compared, not bound)


class RouterAddress:
    """Endpoints of a router, such as ``tcp/localhost:7447``, and where they were set. Immutable.

    Not a NamedTuple, which would delay the start of every command by two milliseconds.

    Args:
        endpoints: Endpoints of the router; see the property.
        origin: Variable or file that sets the endpoints; see the property.
    """

    __slots__ = ("_endpoints", "_origin")

    def __init__(self, endpoints: Iterable[str], origin: str | None = None) -> None:
        self._endpoints = tuple(endpoints)
        self._origin = origin

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Endpoints, any of which may be used; none if routers are found by multicast."""
        return self._endpoints

    @property
    def origin(self) -> str | None:
        """Environment variable or file that sets the endpoints; None for the default."""
        return self._origin

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RouterAddress):
            return NotImplemented
        return (self._endpoints, self._origin) == (other._endpoints, other._origin)

    def __hash__(self) -> int:
        return hash((self._endpoints, self._origin))

    def __repr__(self) -> str:
        return f"RouterAddress({self._endpoints!r}, {self._origin!r})"

    def __str__(self) -> str:
        where = " or ".join(self.endpoints) or "no endpoint"
        return f"{where} (from {self.origin})" if self.origin else where

    @property
    def text(self) -> str:
        """Endpoints of the address, joined by commas."""
        return ", ".join(self.endpoints)

    @property
    def fault(self) -> str | None:
        """Reason why the first invalid endpoint is invalid; None if all are valid."""
        return next(filter(None, map(_fault, self.endpoints)), None)

    @property
    def is_on_this_machine(self) -> bool:
        """Whether all endpoints, if any, are loopback addresses or Unix sockets."""
        return all(_is_local(endpoint) for endpoint in self.endpoints)

    def serves(self, other: RouterAddress) -> bool:
        """Return whether sessions with another address find a router that listens at this one.

        Loopback addresses with the same port count as equal.
        """
        return any(_serves(ours, theirs) for ours in self.endpoints for theirs in other.endpoints)

    def is_missed_by(self, other: RouterAddress) -> bool:
        """Return whether sessions with another, nonempty address find no router at this one."""
        return bool(other.endpoints) and not self.serves(other)

    def to_connect(self) -> RouterAddress:
        """Return this address with wildcard hosts replaced by loopback ones, to connect locally."""
        return RouterAddress(map(_connectable, self._endpoints), self._origin)


DEFAULT_ADDRESS = RouterAddress((DEFAULT_ENDPOINT,))


def tcp_address(endpoint: str) -> tuple[str, int | None]:
    """Return host and port of a TCP endpoint; the port is None for other kinds."""
    protocol, host, port = _parts(endpoint)
    return host.strip("[]"), parse_decimal(port) if protocol == "tcp" else None


def _fault(endpoint: str) -> str | None:
    protocol, host, port = _parts(endpoint)
    number = parse_decimal(port)
    if protocol not in _PROTOCOLS_WITH_PORTS or (host and number and number <= _LARGEST_PORT):
        return None
    return f"{endpoint} does not end in a colon and a port from 1 to {_LARGEST_PORT}"


def _parts(endpoint: str) -> tuple[str, str, str]:
    """Protocol, host and port of ``protocol/host:port?metadata#settings``."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.partition("#")[0].partition("?")[0].rpartition(":")
    return protocol, host, port


def _is_local(endpoint: str) -> bool:
    protocol, host, _ = _parts(endpoint)
    return host in _LOOPBACK or host.startswith("127.") or protocol.startswith("unix")


def _serves(listening: str, wanted: str) -> bool:
    if listening.partition("#")[0] == wanted.partition("#")[0]:
        return True
    protocol, host, port = _parts(listening)
    if not port or (protocol, port) != _parts(wanted)[::2]:
        return False
    return _is_local(wanted) and (host in _WILDCARDS or _is_local(listening))


def _connectable(endpoint: str) -> str:
    protocol, host, port = _parts(endpoint)
    return f"{protocol}/{_WILDCARDS[host]}:{port}" if host in _WILDCARDS else endpoint

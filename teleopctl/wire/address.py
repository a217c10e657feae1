"""Where a router is: the one value that sessions, the daemon and all messages take it from.

Two places are told apart. A session connects to ``connect/endpoints`` of the session's
configuration; a router listens on ``listen/endpoints`` of the router's, and its own
``connect/endpoints`` name other routers. They are the same place unless a configuration file or
``ZENOH_CONFIG_OVERRIDE`` says otherwise.
"""

from __future__ import annotations

from typing import NamedTuple

DEFAULT_ENDPOINT = "tcp/localhost:7447"

_LOOPBACK = ("localhost", "[::1]")
_WILDCARDS = {"[::]": "localhost", "0.0.0.0": "127.0.0.1"}  # noqa: S104 (compared, not bound)


class RouterAddress(NamedTuple):
    """The endpoints of a router, such as ``tcp/localhost:7447``, and who named them.

    Attributes:
        endpoints: Any of them will do; none where routers are found by other means (multicast).
        origin: The environment variable or the file that they are from; None is the default.
    """

    endpoints: tuple[str, ...]
    origin: str | None = None

    def __str__(self) -> str:
        where = " or ".join(self.endpoints) or "no endpoint"
        return f"{where} (from {self.origin})" if self.origin else where

    @property
    def text(self) -> str:
        """The endpoints alone, for a table or for JSON."""
        return ", ".join(self.endpoints)

    @property
    def is_on_this_machine(self) -> bool:
        """Whether every endpoint is a loopback address, or a socket in the file system."""
        return all(_is_local(endpoint) for endpoint in self.endpoints)

    def serves(self, other: RouterAddress) -> bool:
        """Whether a router that listens here is one that sessions of the other address look for.

        Loopback addresses with the same port are taken for one place.
        """
        return any(_serves(ours, theirs) for ours in self.endpoints for theirs in other.endpoints)

    def to_connect(self) -> RouterAddress:
        """The address to connect to from this machine: no program connects to a wildcard."""
        return self._replace(endpoints=tuple(_connectable(text) for text in self.endpoints))


DEFAULT_ADDRESS = RouterAddress((DEFAULT_ENDPOINT,))


def tcp_address(endpoint: str) -> tuple[str, int | None]:
    """Host and port of a TCP endpoint; the port is None where the endpoint is of another kind."""
    protocol, host, port = _parts(endpoint)
    if protocol != "tcp" or not port.isdigit():
        return host, None
    return host.strip("[]"), int(port)


def _parts(endpoint: str) -> tuple[str, str, str]:
    """Protocol, host and port of ``protocol/host:port#settings``."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.partition("#")[0].rpartition(":")
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

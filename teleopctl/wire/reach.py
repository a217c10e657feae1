"""Addresses at which a router listens, and whether other machines can reach them.

The administration space of a router, also of ``rmw_zenohd``, lists them with each wildcard replaced
by the addresses of the machine's interfaces. If a router disables that space, the addresses that
listen on the port are read from the operating system.
"""

from __future__ import annotations

import json
from contextlib import suppress

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.wire.address import RouterAddress, tcp_address
from teleopctl.wire.config import probe_config
from teleopctl.wire.peer_discovery import router_key
from teleopctl.wire.session import open_configured

if TYPE_CHECKING:
    import zenoh

_LONGEST_WAIT_S = 1.0
# Links over which Zenoh can authenticate both sides by certificates, if configured.
_WITH_CERTIFICATES = ("tls/", "quic/")
_WILDCARDS = ("0.0.0.0", "::")  # noqa: S104 (compared, not bound)

HOW_TO_CLOSE = (
    "Let it listen at loopback addresses alone (tcp/localhost:PORT), or let only machines that may "
    "command the robot reach it: by a firewall, a VPN, or Zenoh's TLS with certificates."
)
"""Hint for a router that other machines can reach."""


class RouterReach:
    """Addresses at which a router listens, and those that other machines can reach.

    Attributes:
        addresses: Endpoints with concrete addresses; empty if they are unknown.
        beyond: Endpoints among them that other machines can reach.
    """

    def __init__(self, addresses: tuple[str, ...]) -> None:
        self.addresses = addresses
        self.beyond = tuple(
            each for each in addresses if not RouterAddress((each,)).is_on_this_machine
        )

    @property
    def danger(self) -> str | None:
        """Warning that other machines can reach the router, or perhaps can; None if none can."""
        if not self.addresses:
            return (
                "The router's addresses are unknown: it keeps Zenoh's administration space closed."
            )
        if not self.beyond:
            return None
        certified = all(each.startswith(_WITH_CERTIFICATES) for each in self.beyond)
        return (
            f"The router listens at {', '.join(self.beyond)}: every machine that reaches "
            f"{'one of these addresses' if len(self.beyond) > 1 else 'this address'} can "
            + (
                "connect, and whether certificates are required is a matter of its configuration."
                if certified
                else "read and command all nodes, without authentication."
            )
        )


def router_reach(address: RouterAddress) -> RouterReach:
    """Return a `RouterReach` with the addresses at which a running router listens.

    Raises:
        RouterNotRunning: No router responds at the address.
        UsageError: The configuration of sessions cannot be used.
        UnsupportedError: See `check_security`.
    """
    with open_configured(probe_config(address)) as session:
        found = _reported(session)
    # Sorted, IPv4 first: the order in which a router lists them changes from start to start.
    return RouterReach(
        tuple(sorted(found or _listening_here(address), key=lambda each: ("[" in each, each)))
    )


def _reported(session: zenoh.Session) -> tuple[str, ...]:
    """The locators of the routers that a session is connected to."""
    found: dict[str, None] = {}
    for router in session.info.routers_zid():
        for reply in session.get(router_key(str(router)), timeout=_LONGEST_WAIT_S):
            with suppress(ValueError, KeyError, TypeError):
                if reply.ok is not None:
                    report = json.loads(reply.ok.payload.to_bytes())
                    found.update(dict.fromkeys(map(str, report["locators"])))
    return tuple(found)


def _listening_here(address: RouterAddress) -> tuple[str, ...]:
    """The addresses of this machine at which a program listens on the ports of an address."""
    import psutil

    ports = {tcp_address(endpoint)[1] for endpoint in address.endpoints}
    found: dict[str, None] = {}
    with suppress(psutil.Error):
        for each in psutil.net_connections("tcp"):
            if each.status == psutil.CONN_LISTEN and each.laddr and each.laddr.port in ports:
                for host in _addresses(each.laddr.ip):
                    found[f"tcp/{host}:{each.laddr.port}"] = None
    return tuple(found)


def _addresses(host: str) -> list[str]:
    """Host in the form of endpoints; for a wildcard, the addresses of the interfaces."""
    import psutil

    hosts = [host]
    if host in _WILDCARDS:
        hosts = [
            each.address.partition("%")[0]
            for addresses in psutil.net_if_addrs().values()
            for each in addresses
            if each.family.name in ("AF_INET", "AF_INET6")
            and (host == "::" or each.family.name == "AF_INET")
        ]
    return [f"[{each}]" if ":" in each else each for each in hosts]

"""Which local connections the sessions of a graph have, as the router tells them.

A session's token in the graph says nothing of its process. The router's administration space lists
each session with the address that it connects from, which the operating system knows a process of.
"""

from __future__ import annotations

import json

import zenoh

from teleopctl.typed import Any
from teleopctl.wire.roll_call import router_key

_LONGEST_WAIT_S = 1.0


def session_ports(session: zenoh.Session) -> dict[str, set[int]]:
    """The TCP ports from which sessions are connected to a router, by their Zenoh ids.

    Those of other machines are among them: a port is one of this machine only if a process here
    has a connection from that port to that router.

    Args:
        session: Any session that is connected to a router.
    """
    found: dict[str, set[int]] = {}
    for router in session.info.routers_zid():
        for reply in session.get(router_key(str(router)), timeout=_LONGEST_WAIT_S):
            if reply.ok is not None:
                for peer, port in _ports(reply.ok.payload.to_bytes()):
                    found.setdefault(peer, set()).add(port)
    return found


def _ports(report: bytes) -> list[tuple[str, int]]:
    """Read a router's report; one of another form has none."""
    try:
        sessions: list[dict[str, Any]] = json.loads(report)["sessions"]
        return [
            (str(entry["peer"]), int(link["dst"].rpartition(":")[2]))
            for entry in sessions
            for link in entry["links"]
            if link["dst"].startswith(("tcp/", "tls/"))
        ]
    except (ValueError, KeyError, TypeError, AttributeError):
        return []

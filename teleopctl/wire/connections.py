"""Connections of a router's sessions: their local TCP ports, and whether they are suspended.

A session's tokens in the graph do not identify its process. The router's administration space lists
each session with the address that it connects from, and the operating system lists the process of
that address.
"""

from __future__ import annotations

import zenoh

from teleopctl.base.typed import Any
from teleopctl.wire.peer_discovery import router_key

_LONGEST_WAIT_S = 1.0


def session_ports(session: zenoh.Session) -> dict[str, set[int]]:
    """Return the source TCP ports of all sessions connected to the router, by their Zenoh ids.

    Sessions of other machines are included: a port is one of this machine only if a process of this
    machine has a connection from that port to that router.

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


def is_frozen(session: zenoh.Session, zid: str) -> bool:
    """Return whether the process of a session is suspended, so that not even Zenoh answers.

    Zenoh's own threads reply while a process is merely busy. False for a session without an
    administration space, such as a client's.

    Args:
        session: Any session of the graph.
        zid: Zenoh id of the session in question.
    """
    replies = list(session.get(f"@/{zid}/peer", timeout=_LONGEST_WAIT_S))
    # A timeout is an error reply of its own; without any reply, no session serves the key.
    return bool(replies) and all(reply.ok is None for reply in replies)


def _ports(report: bytes) -> list[tuple[str, int]]:
    """Peers and TCP ports in a router's report; empty for a report of another form."""
    import json  # short commands that call a service read no report

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

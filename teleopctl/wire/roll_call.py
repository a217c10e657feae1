"""Whom the router lists, and whether it has heard the tokens of all of them.

A router of Zenoh 1.9 or newer drops the tokens that a peer of Zenoh 1.8 or older (ROS 2 of 2026)
hands over as it connects; of those it hears only what is announced later. A node that was there
before the router (re)started would stay unknown to whoever asks the router alone.
"""

from __future__ import annotations

import zenoh

from teleopctl.wire.keys import LIVELINESS_PREFIX

# Of every domain: to the router, peers of all domains are alike.
_FIRST_NODES = f"{LIVELINESS_PREFIX}/*/*/0/0/NN/**"
_LONGEST_WAIT_S = 1.0


def router_key(router: str) -> str:
    """Return the key of a router's entry in its administration space, by its Zenoh id."""
    return f"@/{router}/router"


def listed_peers(report: bytes) -> set[str]:
    """Return the Zenoh ids of the peers in a router's report."""
    import json

    try:
        sessions = json.loads(report)["sessions"]
        return {entry["peer"] for entry in sessions if entry["whatami"] == "peer"}
    except (ValueError, KeyError, TypeError):
        return set()


def router_has_all(session: zenoh.Session) -> bool:
    """Wait until the router has forwarded all that was sent; return False without a router.

    The router takes what comes over a connection in order, so that its answer follows.

    Args:
        session: A session that sent something.
    """
    if session.info.peers_zid():
        return False
    for router in session.info.routers_zid():
        for _ in session.get(router_key(str(router)), timeout=_LONGEST_WAIT_S):
            pass
    return True


def router_knows_all(session: zenoh.Session) -> bool:
    """Return whether the router has the tokens of all peers connected to it.

    A process numbers its nodes and endpoints from 0 and announces them in that order. Whose first
    node the router knows, of that process it missed nothing; a peer whose first node it does not
    know may have none, or may have been there before the router.

    Args:
        session: A session in client mode.
    """
    reports = [
        reply.ok.payload.to_bytes()
        for router in session.info.routers_zid()
        for reply in session.get(router_key(str(router)), timeout=_LONGEST_WAIT_S)
        if reply.ok is not None
    ]
    known = {
        str(reply.ok.key_expr).split("/")[2]
        for reply in session.liveliness().get(_FIRST_NODES, timeout=_LONGEST_WAIT_S)
        if reply.ok is not None
    }
    own = str(session.zid())
    return all(
        _names_only(report, own, known) or listed_peers(report) <= known for report in reports
    )


def _names_only(report: bytes, own: str, known: set[str]) -> bool:
    """Whether all whom a report names, peers or not, are known, as far as a glance can tell.

    So it is nearly always, and the import of json takes as long as all that is asked here.
    """
    _, *parts = report.decode(errors="replace").split('"peer":"')
    named = {part.partition('"')[0] for part in parts}
    return own in named and named <= {own, *known}

"""Discovery of peers: waits until a new peer is connected to the router and to its peers.

A Zenoh peer discovers the other peers through the router, after its session has opened. Messages
published before that do not reach them, without any error. The router's administration space lists
the sessions connected to it, and Zenoh reports each new connection: together they show when a new
peer is connected to all others.

A router of Zenoh 1.9 or newer drops the tokens that a peer of Zenoh 1.8 or older (ROS 2 of 2026)
sends when it connects, and receives only those that are declared later. A node that existed before
the router (re)started would stay unknown to a session that queries the router alone.
"""

from __future__ import annotations

import os
import time

import zenoh

from teleopctl.base.typed import Collection, cast
from teleopctl.wire.address import RouterAddress
from teleopctl.wire.config import start_hint
from teleopctl.wire.keys import LIVELINESS_PREFIX

# Of every domain, since the router's report lists the peers of all domains.
_FIRST_NODES = f"{LIVELINESS_PREFIX}/*/*/0/0/NN/**"
_LONGEST_REPORT_S = 1.0


def router_key(router: str) -> str:
    """Return the key of a router's report in the administration space, by its Zenoh id."""
    return f"@/{router}/router"


def peers_in_report(report: bytes) -> set[str]:
    """Return the Zenoh ids of the peers in a router's report; empty if it is malformed."""
    import json

    try:
        sessions = json.loads(report)["sessions"]
        return {entry["peer"] for entry in sessions if entry["whatami"] == "peer"}
    except (ValueError, KeyError, TypeError):
        return set()


def flush_to_router(session: zenoh.Session) -> bool:
    """Wait until the router has processed a session's messages; False at once if it has peers.

    A router processes the messages of a connection in order, so that it replies to a query after
    them. Data for peers does not pass through the router.

    Args:
        session: Session whose sent messages are waited for.
    """
    if session.info.peers_zid():
        return False
    for router in session.info.routers_zid():
        for _ in session.get(router_key(str(router)), timeout=_LONGEST_REPORT_S):
            pass
    return True


def router_has_all_tokens(session: zenoh.Session) -> bool:
    """Return whether the router has the tokens of all peers that are connected to it.

    A process numbers its nodes and endpoints from 0 and declares them in that order. If the router
    has the token of the first node of a process, it has all of them. A peer whose first node the
    router lacks may have no nodes, or may have existed before the router.

    Args:
        session: Session in client mode.
    """
    # Both queries are sent before a reply is awaited.
    asked = [
        session.get(router_key(str(router)), timeout=_LONGEST_REPORT_S)
        for router in session.info.routers_zid()
    ]
    known = {
        str(reply.ok.key_expr).split("/")[2]
        for reply in session.liveliness().get(_FIRST_NODES, timeout=_LONGEST_REPORT_S)
        if reply.ok is not None
    }
    reports = [
        reply.ok.payload.to_bytes() for each in asked for reply in each if reply.ok is not None
    ]
    own = str(session.zid())
    return all(
        _names_only(report, own, known) or peers_in_report(report) <= known for report in reports
    )


def _names_only(report: bytes, own: str, known: set[str]) -> bool:
    """Whether all sessions in a report, peers or not, are known, by a search of its text.

    This is nearly always so, and the import of json takes as long as all queries of this check.
    """
    _, *parts = report.decode(errors="replace").split('"peer":"')
    named = {part.partition('"')[0] for part in parts}
    return own in named and named <= {own, *known}


LONGEST_WAIT_S = 0.5
"""Longest wait for router and peers, as long as Zenoh's own: the router still lists a peer for a
while after it was killed."""

_ATTEMPTS = "ZENOH_ROUTER_CHECK_ATTEMPTS"


def wait_for_discovery(session: zenoh.Session, router: RouterAddress) -> None:
    """Wait for a limited time until a new peer is connected to others; warn without a router.

    ``ZENOH_ROUTER_CHECK_ATTEMPTS`` is read as in rmw_zenoh: the number of seconds to wait for a
    router; 0 waits forever, a negative number does not wait.

    Args:
        session: Session in peer mode.
        router: Address at which the session looks for the router, for the warning.
    """
    patience_s = _router_patience_s()
    if patience_s is not None and patience_s < 0:
        return
    if not wait_for_peers(session, patience_s) and not session.info.routers_zid():
        import logging

        logging.getLogger(__name__).warning(
            "No router answers at %s. Continuing without one: other processes become visible as "
            "soon as it runs. %s",
            router,
            start_hint(router),
        )


def wait_for_peers(
    session: zenoh.Session,
    router_within_s: float | None = LONGEST_WAIT_S,
    peers_within_s: float = LONGEST_WAIT_S,
) -> bool:
    """Wait until a session is connected to all peers of its router; return False on timeout.

    Args:
        session: Session in peer mode.
        router_within_s: Longest wait for the router, in seconds; None waits forever.
        peers_within_s: Longest wait for the peers after that, in seconds.
    """
    import threading  # takes 5 ms, which clients do not need

    changed = threading.Condition()
    connected: dict[str, str] = {}

    def note(event: zenoh.TransportEvent) -> None:
        with changed:
            if event.kind == zenoh.SampleKind.PUT:
                connected[str(event.transport.zid)] = str(event.transport.whatami)
            else:
                connected.pop(str(event.transport.zid), None)
            changed.notify_all()

    with session.info.declare_transport_events_listener(note, history=True):
        with changed:
            if not changed.wait_for(lambda: "router" in connected.values(), router_within_s):
                return False
            router = next(zid for zid, role in connected.items() if role == "router")
        deadline = time.monotonic() + peers_within_s
        report = _ask(session, router_key(router), peers_within_s)
        if not report:
            return False
        others = peers_in_report(report) - {str(session.zid())}
        with changed:
            return changed.wait_for(
                lambda: others <= connected.keys(), max(0.0, deadline - time.monotonic())
            )


def wait_for_peer_tokens(
    session: zenoh.Session,
    within_s: float = LONGEST_WAIT_S,
    *,
    except_for: Collection[str] = (),
) -> bool:
    """Wait until the liveliness tokens of connected peers are received; return whether any waited.

    A peer sends its tokens when a connection opens, so that they have arrived when the peer has
    replied to a later query. Zenoh reports a connection shortly before it queries the peer for
    tokens.

    Args:
        session: Session in peer mode.
        within_s: Longest wait for all peers, in seconds.
        except_for: Zenoh ids of peers whose tokens are known.
    """
    deadline = time.monotonic() + within_s
    peers = [peer for peer in map(str, session.info.peers_zid()) if peer not in except_for]
    for peer in peers:
        _ask(session, f"@/{peer}/peer", max(0.0, deadline - time.monotonic()))
    return bool(peers)


def _ask(session: zenoh.Session, key: str, timeout_s: float) -> bytes:
    """Query the administration space of a router or peer; return its report, empty on timeout."""
    import threading

    offered = threading.Event()

    def note(status: zenoh.MatchingStatus) -> None:
        if status.matching:
            offered.set()

    # Zenoh rejects a timeout of 0.
    with session.declare_querier(key, timeout=max(timeout_s, 0.001)) as querier:
        querier.declare_matching_listener(note)
        # A query sent before its queryable is known in this session would end without a reply.
        if not cast(zenoh.MatchingStatus, querier.matching_status).matching:
            offered.wait(timeout_s)
        for reply in querier.get():
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
    return b""


def _router_patience_s() -> float | None:
    """Longest wait for a router, in seconds; None waits forever, a negative number not at all."""
    try:
        attempts = int(os.environ.get(_ATTEMPTS, ""))
    except ValueError:
        return LONGEST_WAIT_S
    # rmw_zenoh checks once a second; here the connection itself ends the wait.
    return float(attempts) if attempts else None

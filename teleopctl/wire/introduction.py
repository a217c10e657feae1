"""Wait until a new peer is connected to the router and to the peers that are already there.

A Zenoh peer learns of the others from the router, after its session has opened. Whatever it
publishes before that is lost to them without a trace. The router's administration space lists who
is connected to it, and Zenoh reports each connection as it comes about: together they tell when a
new peer has met everybody.
"""

import os
import threading
import time

import zenoh

from teleopctl.base.typed import cast
from teleopctl.wire.address import RouterAddress
from teleopctl.wire.config import how_to_start
from teleopctl.wire.roll_call import listed_peers, router_key

LONGEST_WAIT_S = 0.5
"""No longer than Zenoh's own wait: a peer that left without a word is listed for a while."""

_ATTEMPTS = "ZENOH_ROUTER_CHECK_ATTEMPTS"


def introduce(session: zenoh.Session, router: RouterAddress) -> None:
    """Wait until a new peer has met the others; warn if there is no router.

    ``ZENOH_ROUTER_CHECK_ATTEMPTS`` is honoured as by a ROS process: how many seconds to wait for a
    router, 0 for ever, a negative number not at all.

    Args:
        session: A session in peer mode.
        router: Where it looks for the router.
    """
    patience_s = _router_patience_s()
    if patience_s is not None and patience_s < 0:
        return
    if not meet_peers(session, patience_s) and not session.info.routers_zid():
        import logging

        logging.getLogger(__name__).warning(
            "No router answers at %s. Going on without one: other processes become visible as "
            "soon as it runs. %s",
            router,
            how_to_start(router),
        )


def meet_peers(
    session: zenoh.Session,
    router_within_s: float | None = LONGEST_WAIT_S,
    peers_within_s: float = LONGEST_WAIT_S,
) -> bool:
    """Wait until the session is connected to all peers of its router, or a timeout.

    Args:
        session: A session in peer mode.
        router_within_s: How long to wait for the router at most, in seconds; None for ever.
        peers_within_s: How long to wait for the peers after that, in seconds.

    Returns:
        Whether everybody has been met.
    """
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
        others = _peers_of(session, router, peers_within_s)
        others.discard(str(session.zid()))
        with changed:
            return changed.wait_for(
                lambda: others <= connected.keys(), max(0.0, deadline - time.monotonic())
            )


def hear_peers(session: zenoh.Session, within_s: float = LONGEST_WAIT_S) -> None:
    """Wait until the tokens of all connected peers have come, or a timeout.

    A peer hands its tokens over when a connection opens, so that they are here when it has answered
    a question that was put after that.
    """
    deadline = time.monotonic() + within_s
    for peer in session.info.peers_zid():
        _ask(session, f"@/{peer}/peer", max(0.0, deadline - time.monotonic()))


def _peers_of(session: zenoh.Session, router: str, timeout_s: float) -> set[str]:
    """Ask a router for the identities of the peers that are connected to it."""
    return listed_peers(_ask(session, router_key(router), timeout_s))


def _ask(session: zenoh.Session, key: str, timeout_s: float) -> bytes:
    """What a participant tells about itself under its key; nothing when the time is up."""
    offered = threading.Event()

    def note(status: zenoh.MatchingStatus) -> None:
        if status.matching:
            offered.set()

    # Zenoh takes no time limit of nothing.
    with session.declare_querier(key, timeout=max(timeout_s, 0.001)) as querier:
        querier.declare_matching_listener(note)
        # A query sent before the other has told what it offers would end without an answer.
        if not cast(zenoh.MatchingStatus, querier.matching_status).matching:
            offered.wait(timeout_s)
        for reply in querier.get():
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
    return b""


def _router_patience_s() -> float | None:
    """How long to wait for a router, in seconds; None for ever, negative not at all."""
    try:
        attempts = int(os.environ.get(_ATTEMPTS, ""))
    except ValueError:
        return LONGEST_WAIT_S
    # ROS looks once a second; here the connection itself ends the wait.
    return float(attempts) if attempts else None

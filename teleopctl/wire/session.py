"""Zenoh sessions: how a process enters the ROS graph."""

from __future__ import annotations

import _thread
import os

import zenoh

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import UnavailableError, UsageError
from teleopctl.wire.address import RouterAddress
from teleopctl.wire.config import (
    SessionConfig,
    session_config,
    start_hint,
    zenoh_error_text,
)
from teleopctl.wire.keys import parse_decimal

if TYPE_CHECKING:
    from teleopctl.wire.config import SessionMode

# Zenoh ids of this process's client sessions: Zenoh does not report the mode of a session.
_clients: set[str] = set()

# Longest wait for a router that has just responded: only a busy machine delays it.
_BUSY_ROUTER_S = 5.0

# Closing a session takes a few milliseconds; on a busy machine tenths of a second.
_LONGEST_CLOSE_S = 2.0


class RouterNotRunning(UnavailableError):
    """No router answers at the address of a session.

    Attributes:
        router: Address at which the session looked, with the variable or file that sets it.
    """

    def __init__(self, router: RouterAddress) -> None:
        where = f" at {router}" if router.endpoints else f", and {router.origin} sets no address"
        super().__init__(f"No router answers{where}.", hint=start_hint(router))
        self.router = router


def domain_id() -> int:
    """Return the domain id of ``ROS_DOMAIN_ID``, by default 0.

    Raises:
        UsageError: The variable does not hold a number.
    """
    text = os.environ.get("ROS_DOMAIN_ID", "").strip()
    domain = parse_decimal(text or "0")
    if domain is None:
        raise UsageError(f"ROS_DOMAIN_ID is {text!r}, but a domain is a number from 0.")
    return domain


def open_session(mode: SessionMode) -> zenoh.Session:
    """Open a Zenoh session as the environment configures it; the caller closes it.

    A client is connected to the router only, which is enough for short commands. If the router
    lacks tokens of its peers, a peer session is returned instead of a client, and queries the peers
    itself.

    A peer exchanges data with the other peers directly. It is returned once it is connected to
    those that the router lists; their subscriptions arrive within another millisecond or so, so
    that a publisher that must not lose its first message waits for a match. A peer also starts
    without a router, with a warning, and connects later.

    Raises:
        RouterNotRunning: There is no router for a client to connect to.
        UsageError: The configuration is invalid.
        UnavailableError: Zenoh cannot open the session.
    """
    config = session_config(mode)
    session = open_configured(config)
    if mode == "client" and config.mode == "client":
        from teleopctl.wire.peer_discovery import router_has_all_tokens

        if not router_has_all_tokens(session):
            config = session_config("peer")
            # With a router on another machine the mode stays client: its peers are unreachable.
            if config.mode == "peer":
                from teleopctl.wire.peer_discovery import wait_for_peer_tokens, wait_for_peers

                session.close()
                session = open_configured(config)
                wait_for_peers(session, _BUSY_ROUTER_S)
                wait_for_peer_tokens(session)
    return session


def open_configured(config: SessionConfig) -> zenoh.Session:
    """Open a Zenoh session with a given configuration; the caller closes it.

    Raises:
        RouterNotRunning: There is no router for a client to connect to.
        UnavailableError: Zenoh cannot open the session.
        UnsupportedError: See `check_security`.
    """
    if "RUST_LOG" in os.environ:
        zenoh.try_init_log_from_env()
    try:
        session = open_zenoh(config.zenoh)
    except zenoh.ZError as error:
        if config.mode == "client":
            raise RouterNotRunning(config.router) from error
        raise UnavailableError(f"Zenoh cannot open a session: {zenoh_error_text(error)}") from error
    if config.mode == "client":
        _clients.add(str(session.zid()))
    elif config.router.endpoints:
        from teleopctl.wire.peer_discovery import wait_for_discovery

        wait_for_discovery(session, config.router)
    return session


def open_zenoh(config: zenoh.Config) -> zenoh.Session:
    """Open a Zenoh session or router with a configuration, if ROS security allows it.

    Raises:
        zenoh.ZError: Zenoh cannot open the session.
        UnsupportedError: See `check_security`.
    """
    if "ROS_SECURITY_ENABLE" in os.environ:
        from teleopctl.wire.security import check_security

        check_security()
    return zenoh.open(config)


def is_client(session: zenoh.Session) -> bool:
    """Return whether a session was opened as a client, whose data all passes the router."""
    return str(session.zid()) in _clients


def close_session(session: zenoh.Session) -> None:
    """Close a session; if that takes longer than 2 s, abandon it with a warning.

    Zenoh notifies each peer, and waits ten seconds for a peer that reads nothing; this is left to a
    thread. The abandoned session is unusable, and its sockets are closed with the process.
    """
    faults = []
    # Short commands do not import threading.
    closing = _thread.allocate_lock()
    closing.acquire()

    def close() -> None:
        try:
            session.close()
        except zenoh.ZError as error:
            faults.append(zenoh_error_text(error))
        finally:
            closing.release()

    try:
        _thread.start_new_thread(close, ())
    except RuntimeError:
        close()  # at the end of a program Python 3.12 starts no threads
    if not closing.acquire(timeout=_LONGEST_CLOSE_S):
        faults.append(f"no end after {_LONGEST_CLOSE_S:g} s")
    if faults:
        import logging

        logging.getLogger(__name__).warning(
            "A process of the graph does not read its messages, so the session could not be "
            "closed properly: %s",
            faults[0],
        )

"""Zenoh sessions: how a process enters the ROS graph."""

import os

import zenoh

from teleopctl.errors import UnavailableError, UsageError
from teleopctl.wire.config import (
    SessionMode,
    has_endpoints,
    mode_of,
    reason_of,
    router_endpoint,
    session_config,
)
from teleopctl.wire.keys import decimal


class RouterNotRunning(UnavailableError):
    """No router answers at the endpoint where one is expected."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(
            f"No router answers at {endpoint}.",
            hint="Start one with 'teleopctl daemon start'.",
        )
        self.endpoint = endpoint


def domain_id() -> int:
    """Return the ROS domain from ``ROS_DOMAIN_ID``, by default 0.

    Raises:
        TeleopctlError: The variable does not hold a number.
    """
    text = os.environ.get("ROS_DOMAIN_ID", "").strip()
    domain = decimal(text or "0")
    if domain is None:
        raise UsageError(f"ROS_DOMAIN_ID is {text!r}, but a domain is a number from 0.")
    return domain


def open_session(mode: SessionMode) -> zenoh.Session:
    """Open a session; whoever opens it closes it.

    A client speaks to the router alone: for short commands. A peer talks to the other peers
    directly. It is returned once it is connected to those that the router knows; what they
    subscribe to reaches it within another millisecond or so, so that a publisher that must not
    lose its first message waits for a match. A peer also starts without a router, with a warning,
    and finds it later.

    Raises:
        RouterNotRunning: There is no router for a client to connect to.
        TeleopctlError: The configuration is faulty, or a peer cannot listen.
    """
    config = session_config(mode)
    # A configuration file or an override may want it otherwise.
    configured_mode, seeks_router = mode_of(config), has_endpoints(config)
    if "RUST_LOG" in os.environ:
        zenoh.try_init_log_from_env()
    try:
        session = zenoh.open(config)
    except zenoh.ZError as error:
        if configured_mode == "client":
            raise RouterNotRunning(router_endpoint()) from error
        raise UnavailableError(f"Zenoh cannot open a session: {reason_of(error)}") from error
    if configured_mode == "peer" and seeks_router:
        from teleopctl.wire.introduction import introduce

        introduce(session)
    return session

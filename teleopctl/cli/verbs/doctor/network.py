"""Checks of what introduces nodes to each other."""

from __future__ import annotations

from collections.abc import Iterator

from teleopctl.cli.verbs.doctor.finding import Finding, warning
from teleopctl.errors import TeleopctlError


def check_router() -> Iterator[Finding]:
    """Yield faults of the router: not found, wrong port holder, open to the network."""
    from teleopctl.wire import (
        HOW_TO_CLOSE,
        daemon_address,
        port_holder,
        router_is_running,
        router_reach,
        session_config,
    )

    try:
        sessions, daemon = session_config("client").router, daemon_address()
        is_there = router_is_running(sessions)
    except TeleopctlError as error:
        yield Finding(error.message, error.hint or "")
        return
    if is_there:
        danger = router_reach(sessions).danger
        if danger is not None:
            yield warning(danger, HOW_TO_CLOSE)
    else:
        holder = port_holder(sessions)
        if holder is None:
            yield Finding(
                f"No router answers at {sessions}: nodes do not find each other.",
                "Start it with `teleopctl daemon start`; nodes and launches start it themselves."
                if daemon.serves(sessions)
                else "Start it there.",
            )
        else:
            port, name = holder
            yield Finding(
                f"Port {port} is taken by {name}, which does not answer as a Zenoh router.",
                f"End that program, or use another port: TELEOPCTL_ROUTER=tcp/HOST:{port + 1}",
            )
    if daemon.is_missed_by(sessions):
        yield warning(
            f"The daemon would listen at {daemon}, sessions connect to {sessions}.",
            "Nodes of the two do not see each other unless the routers are connected.",
        )

"""Checks of what introduces nodes to each other."""

from __future__ import annotations

from collections.abc import Iterator

from teleopctl.cli.verbs.doctor.finding import Finding, warning
from teleopctl.errors import TeleopctlError


def check_router() -> Iterator[Finding]:
    """Look for the router where sessions look for it, and who has its port."""
    from teleopctl.wire import daemon_address, port_holder, router_is_running, session_config

    try:
        sessions, daemon = session_config("client").router, daemon_address()
        is_there = router_is_running(sessions)
    except TeleopctlError as error:
        yield Finding(error.message, error.hint or "")
        return
    if not is_there:
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

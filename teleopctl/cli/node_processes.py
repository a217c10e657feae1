"""Processes of this machine in which nodes of the graph run."""

from __future__ import annotations

import contextlib

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.wire import session_ports

if TYPE_CHECKING:
    from collections.abc import Collection

    import zenoh


def pids_of_sessions(session: zenoh.Session, zids: Collection[str]) -> dict[str, int | None]:
    """Return the process ID of each Zenoh session that the router lists, by Zenoh id.

    The router has the TCP port of each session, and the operating system the process of each port.
    So nodes of a launch, of another terminal and of ROS 2 itself are all found. The ID is None for
    a session of another machine or another user; the router lists new sessions with a delay.

    Args:
        session: Any session that is connected to the router.
        zids: Zenoh ids of the sessions in question.
    """
    ports = session_ports(session)
    listed = [zid for zid in zids if zid in ports]
    if not listed:
        return {}
    pid_by_port = _pid_by_port()
    return {
        zid: next((pid_by_port[port] for port in ports[zid] if port in pid_by_port), None)
        for zid in listed
    }


def _pid_by_port() -> dict[int, int]:
    """Return the process IDs of TCP connections by their local ports."""
    import psutil

    pids: dict[int, int] = {}
    try:
        for connection in psutil.net_connections(kind="tcp"):
            if connection.laddr and connection.raddr and connection.pid:
                pids[connection.laddr.port] = connection.pid
    except psutil.AccessDenied:  # macOS lists connections of the user's own processes only
        for process in psutil.process_iter():
            with contextlib.suppress(psutil.Error):
                for own in process.net_connections(kind="tcp"):
                    if own.laddr and own.raddr:
                        pids[own.laddr.port] = process.pid
    return pids

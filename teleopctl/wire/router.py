"""Daemon: a Zenoh router that introduces the processes of the ROS graph to each other.

``python -m teleopctl.wire.router [ENDPOINT ...]`` runs the router in the foreground; the functions
of this module find, start and stop it in the background. A running ``rmw_zenohd`` can be used
instead.

The daemon is the router that listens at `daemon_address`. Sessions connect to that address, unless
``ZENOH_CONFIG_OVERRIDE`` or a configuration file sets another one.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

import zenoh

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.errors import RefusedError, TeleopctlError, UnavailableError
from teleopctl.wire.address import RouterAddress, tcp_address
from teleopctl.wire.config import (
    probe_config,
    router_config,
    session_config,
    start_hint,
    zenoh_error_text,
)
from teleopctl.wire.session import RouterNotRunning, open_configured, open_zenoh

# The rest is imported where needed: most commands only check that the router runs.
if TYPE_CHECKING:
    import psutil

    from teleopctl.base.background import ProcessRecord
    from teleopctl.wire.reach import RouterReach

__all__ = [
    "daemon_address",
    "ensure_router",
    "find_router",
    "port_holder",
    "router_is_running",
    "run_router",
    "start_router",
    "stop_router",
]

_KIND = "router"
_MODULE = "teleopctl.wire.router"
_READY_WITHIN_S = 10.0
# Longest wait for a router while the process that holds the port is unknown.
_UNKNOWN_WITHIN_S = 1.0


def daemon_address() -> RouterAddress:
    """Return the address at which the daemon, a Zenoh router, listens when it runs.

    Raises:
        UsageError: The router's configuration cannot be used.
    """
    return router_config().address


def router_is_running(address: RouterAddress | None = None) -> bool:
    """Return whether a Zenoh router answers at an address, by default the daemon's.

    Raises:
        UsageError: The configuration of sessions or of the router cannot be used.
    """
    try:
        with open_configured(probe_config(address or daemon_address())):
            return True
    except RouterNotRunning:
        return False


def ensure_router() -> None:
    """Start the daemon and wait until ready, unless a router answers at the sessions' address.

    Raises:
        RouterNotRunning: Sessions connect to another address than the daemon's.
        UnavailableError: Another program occupies the port, or the address is another machine's.
        SystemFailureError: The router cannot be started.
        UsageError: The configuration of sessions or of the router cannot be used.
    """
    try:
        open_configured(session_config("client")).close()
    except RouterNotRunning as failure:
        if not daemon_address().serves(failure.router):
            raise
        start_router()


def start_router() -> bool:
    """Start the daemon in the background and wait until ready; return False if a router answers.

    Raises:
        UnavailableError: Another program occupies the port, or the address is another machine's.
        SystemFailureError: The router cannot be started.
        UsageError: The configuration of sessions or of the router cannot be used.
    """
    address = _free_address()
    if address is None:
        return False
    from teleopctl.base import background
    from teleopctl.base.start_timeouts import StartTimeouts

    try:
        background.start(
            "router",
            [sys.executable, "-P", "-m", _MODULE, *address.endpoints],
            kind=_KIND,
            until_ready=StartTimeouts(),
        )
    except TeleopctlError:
        # Two commands may start the daemon at once: one gets the port, and both continue.
        if _router_answers(address):
            return False
        raise
    return True


def run_daemon(
    log_level: str = "info", *, when_up: Callable[[RouterReach], object] | None = None
) -> bool:
    """Run the daemon in this process until a signal; return False if a router answers already.

    Args:
        log_level: Level of Zenoh's log on stdout; ``RUST_LOG`` has priority.
        when_up: Called with the addresses at which the daemon listens, when it has started.

    Raises:
        TeleopctlError: As `start_router` raises.
    """
    address = _free_address()
    if address is None:
        return False
    zenoh.init_log_from_env_or(log_level)
    run_router(address.endpoints, when_up=when_up)
    return True


def _free_address() -> RouterAddress | None:
    """Address at which the daemon can listen; None if a router responds there already."""
    config = router_config()
    address = config.address
    if router_is_running(address):
        return None
    if config.is_stated:
        address = RouterAddress(_endpoints_here(address), address.origin)
    return None if _router_answers(address) else address


def find_router(address: RouterAddress | None = None) -> ProcessRecord | None:
    """Return the process record of the daemon; None if it does not run in the background.

    Args:
        address: Address of the daemon, if it is known; by default `daemon_address`.

    Raises:
        UsageError: The router's configuration cannot be used.
    """
    from teleopctl.base import background

    address = (address or daemon_address()).to_connect()
    for record in background.records():
        if record.kind == _KIND and _listens_at(record).serves(address):
            return record
    return None


def stop_router() -> bool:
    """Stop the daemon that runs in the background; return False if no router answers.

    Raises:
        RefusedError: The router that answers was not started in the background by teleopctl.
        UsageError: The configuration of sessions or of the router cannot be used.
    """
    record = find_router()
    if record is not None:
        from teleopctl.base import background

        background.stop(record)
        return True
    address = daemon_address()
    if router_is_running(address):
        raise RefusedError(
            f"The router at {address} was not started by 'teleopctl daemon start'.",
            hint="Stop it where it was started: it may be rmw_zenohd, or belong to another user.",
        )
    return False


def run_router(
    listen: Sequence[str] = (), *, when_up: Callable[[RouterReach], object] | None = None
) -> None:
    """Run a router at given endpoints until SIGINT or SIGTERM.

    Args:
        listen: Endpoints to listen on, by default those at which sessions look for a router. A
            configuration file or an override has priority. ``localhost`` means every loopback
            address of the machine.
        when_up: Called with the addresses at which the router listens, when it has started.

    Raises:
        UnavailableError: The router cannot listen at the endpoints, or its configuration is
            invalid.
    """
    import signal
    import socket

    from teleopctl.base import background

    waker, woken = socket.socketpair()
    waker.setblocking(False)
    # A byte on a socket wakes the wait below on every system; an event would not on Windows.
    signal.set_wakeup_fd(waker.fileno())
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)
    try:
        session = open_zenoh(router_config(listen).zenoh)
    except (zenoh.ZError, TeleopctlError) as error:
        reason = zenoh_error_text(error) if isinstance(error, zenoh.ZError) else str(error)
        failure = f"The router cannot start: {reason}"
        background.announce_ready(failure)
        raise UnavailableError(failure) from error
    with session:
        background.announce_ready()
        if when_up is not None:
            from teleopctl.wire.reach import router_reach

            when_up(router_reach(daemon_address()))
        woken.recv(1)


def _listens_at(record: ProcessRecord) -> RouterAddress:
    """Address of a daemon: the arguments of its command after the module's name."""
    module = record.command.index("-m") + 1
    return RouterAddress(record.command[module + 1 :])


def _router_answers(address: RouterAddress) -> bool:
    """Whether a router responds at an address; waits for a router that is just starting.

    Raises:
        UnavailableError: A program that is not a router holds a port of the address.
    """
    began_s = known_s = time.monotonic()
    while not router_is_running(address):
        taken = next(_taken_ports(address), None)
        if taken is None:
            return False
        host, port = taken
        holder = _holder(port)
        if holder is not None:
            known_s = time.monotonic()
            gives_up_s = began_s + _READY_WITHIN_S
        else:  # the process has just released the port, or the system hides it
            gives_up_s = known_s + _UNKNOWN_WITHIN_S
        waits = holder is None or _is_our_router(holder)
        if not waits or time.monotonic() >= gives_up_s:
            name = _name_of(holder)
            raise UnavailableError(
                f"Port {port} is taken by {name}, which does not answer as a Zenoh router.",
                hint="End that program, or use another port: "
                f"TELEOPCTL_ROUTER=tcp/{host}:{port + 1}",
            )
    return True


def port_holder(address: RouterAddress) -> tuple[int, str] | None:
    """Return an occupied port of an address, and its process as text (name and PID); or None.

    For an address at which no router responds.
    """
    for _, port in _taken_ports(address):
        return port, _name_of(_holder(port))
    return None


def _name_of(holder: psutil.Process | None) -> str:
    return f"{holder.name()} (pid {holder.pid})" if holder else "another program"


def _taken_ports(address: RouterAddress) -> Iterator[tuple[str, int]]:
    import socket

    for endpoint in address.to_connect().endpoints:
        host, port = tcp_address(endpoint)
        if port is not None:
            with suppress(OSError):
                socket.create_connection((host, port), timeout=1.0).close()
                yield host, port


def _endpoints_here(address: RouterAddress) -> tuple[str, ...]:
    """The endpoints of an address that belong to this machine.

    Raises:
        UnavailableError: All endpoints belong to other machines.
    """
    here = tuple(endpoint for endpoint in address.endpoints if _is_here(endpoint))
    if not here:
        hosts = " or ".join(tcp_address(endpoint)[0] for endpoint in address.endpoints)
        raise UnavailableError(
            f"No router answers at {address}, and it cannot be started from here: {hosts} is not "
            "an address of this machine.",
            hint=start_hint(address),
        )
    return here


def _is_here(endpoint: str) -> bool:
    host, port = tcp_address(endpoint)
    return port is None or any(_can_bind(*info) for info in _resolve(host))


def _resolve(host: str) -> list[tuple[int, Any]]:
    """Family and socket address of each address of a host, with a port of the system's choice."""
    import socket

    try:
        found = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)
    except OSError:
        return []
    return [(family, address) for family, _, _, _, address in found]


def _can_bind(family: int, address: Any) -> bool:
    import socket

    try:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.bind(address)
    except OSError:
        return False
    return True


def _holder(port: int) -> psutil.Process | None:
    """Process that listens on a port; None if the system does not show it."""
    import psutil

    with suppress(psutil.Error):
        for connection in psutil.net_connections("tcp"):
            address = connection.laddr
            listens = connection.status == psutil.CONN_LISTEN and address and address.port == port
            if listens and connection.pid is not None:
                return psutil.Process(connection.pid)
    return None


def _is_our_router(process: psutil.Process | None) -> bool:
    import psutil

    with suppress(psutil.Error):
        return process is not None and _MODULE in process.cmdline()
    return False


def main(args: Sequence[str] | None = None) -> int:
    """Run the router in the foreground at endpoints given as arguments; return the exit status."""
    words = sys.argv[1:] if args is None else list(args)
    try:
        run_router(words)
    except TeleopctlError as error:
        sys.stderr.write(f"{error.message}\n")
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())

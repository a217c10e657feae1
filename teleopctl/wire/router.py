"""The daemon: a Zenoh router that introduces the processes of the graph to each other.

``python -m teleopctl.wire.router [ENDPOINT]`` is the router in the foreground; the functions here
find, start and stop the one in the background. A running ``rmw_zenohd`` serves as well.
"""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import zenoh

from teleopctl.errors import RefusedError, TeleopctlError, UnavailableError
from teleopctl.wire.config import reason_of, router_config, router_endpoint
from teleopctl.wire.session import RouterNotRunning, open_session

# The rest is imported where a router is started or stopped: most commands only find it running.
if TYPE_CHECKING:
    from teleopctl.background import ProcessRecord

__all__ = [
    "ensure_router",
    "find_router",
    "router_endpoint",
    "router_is_running",
    "run_router",
    "start_router",
    "stop_router",
]

_KIND = "router"
_READY_WITHIN_S = 10.0
_LOOPBACK = ("127.0.0.1", "[::1]")


def router_is_running() -> bool:
    """Whether a Zenoh router, ours or another, answers where one is expected."""
    try:
        with open_session("client"):
            return True
    except RouterNotRunning:
        return False


def ensure_router() -> None:
    """Return once a router answers, starting the daemon if there is none.

    Raises:
        TeleopctlError: Something else occupies the port, or the router cannot be started.
    """
    start_router()


def start_router() -> bool:
    """Start the daemon unless a router answers already.

    Returns:
        Whether it was started by this call.

    Raises:
        TeleopctlError: Something else occupies the port, or the router cannot be started.
    """
    if router_is_running():
        return False
    from teleopctl import background

    endpoint = router_endpoint()
    _check_is_here(endpoint)
    _check_port_is_free(endpoint)
    try:
        background.start(
            "router",
            [sys.executable, "-P", "-m", "teleopctl.wire.router", endpoint],
            kind=_KIND,
            ready_within_s=_READY_WITHIN_S,
        )
    except TeleopctlError:
        # Two commands may start it at once; the port lets one of them win, and both go on.
        if router_is_running():
            return False
        _check_port_is_free(endpoint)
        raise
    return True


def find_router() -> "ProcessRecord | None":
    """The record of the daemon at the expected endpoint, None when it was started otherwise."""
    from teleopctl import background

    endpoint = router_endpoint()
    for record in background.records():
        if record.kind == _KIND and record.command[-1] == endpoint:
            return record
    return None


def stop_router() -> bool:
    """Stop the daemon.

    Returns:
        Whether there was one to stop.

    Raises:
        TeleopctlError: The router that answers was not started in the background by teleopctl.
    """
    record = find_router()
    if record is not None:
        from teleopctl import background

        background.stop(record)
        return True
    if router_is_running():
        raise RefusedError(
            f"The router at {router_endpoint()} was not started by 'teleopctl daemon start'.",
            hint="Stop it where it was started: it may be rmw_zenohd, or belong to another user.",
        )
    return False


def run_router(endpoint: str | None = None) -> None:
    """Be the router until SIGINT or SIGTERM.

    Args:
        endpoint: Where to listen, by default where clients expect it. ``localhost`` means every
            loopback address of the machine.

    Raises:
        TeleopctlError: It cannot listen there.
    """
    import signal
    import socket

    from teleopctl import background

    waker, woken = socket.socketpair()
    waker.setblocking(False)
    # A byte on a socket wakes the wait below on every system; an event would not on Windows.
    signal.set_wakeup_fd(waker.fileno())
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)
    try:
        session = zenoh.open(router_config(_listen_endpoints(endpoint or router_endpoint())))
    except (zenoh.ZError, TeleopctlError) as error:
        reason = reason_of(error) if isinstance(error, zenoh.ZError) else str(error)
        failure = f"The router cannot start: {reason}"
        background.announce_ready(failure)
        raise UnavailableError(failure) from error
    with session:
        background.announce_ready()
        woken.recv(1)


def _listen_endpoints(endpoint: str) -> Sequence[str]:
    """Both loopback addresses for ``localhost``, since a client may try either first."""
    protocol, slash, address = endpoint.partition("/")
    host, colon, port = address.rpartition(":")
    if not slash or not colon or host != "localhost":
        return [endpoint]
    ipv4, ipv6 = (f"{protocol}/{loopback}:{port}" for loopback in _LOOPBACK)
    return [ipv4, f"{ipv6}#exit_on_failure=false"]


def _check_port_is_free(endpoint: str) -> None:
    """Raise when a program that is no router has the port of an endpoint."""
    host, port = _tcp_address(endpoint)
    if port is None:
        return
    import socket

    try:
        socket.create_connection((host, port), timeout=1.0).close()
    except OSError:
        return
    raise UnavailableError(
        f"Port {port} is taken by {_holder(port)}, which does not answer as a Zenoh router.",
        hint=f"End that program, or use another port: TELEOPCTL_ROUTER=tcp/{host}:{port + 1}",
    )


def _check_is_here(endpoint: str) -> None:
    """Raise when the address of an endpoint belongs to another machine."""
    host, port = _tcp_address(endpoint)
    if port is None:
        return
    if not any(_can_bind(*info) for info in _resolve(host)):
        raise UnavailableError(
            f"No router answers at {endpoint}, and it cannot be started from here: {host} is not "
            "an address of this machine.",
            hint="Start it there, or correct TELEOPCTL_ROUTER.",
        )


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


def _tcp_address(endpoint: str) -> tuple[str, int | None]:
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.partition("#")[0].rpartition(":")
    if protocol != "tcp" or not port.isdigit():
        return host, None
    return host.strip("[]"), int(port)


def _holder(port: int) -> str:
    """Name the program that listens on a port, as far as the system lets us know."""
    import psutil

    try:
        for connection in psutil.net_connections("tcp"):
            address = connection.laddr
            listens = connection.status == psutil.CONN_LISTEN and address and address.port == port
            if listens and connection.pid is not None:
                return f"{psutil.Process(connection.pid).name()} (pid {connection.pid})"
    except psutil.Error:
        pass
    return "another program"


def main(args: Sequence[str] | None = None) -> int:
    """Run the router in the foreground; the only argument is the endpoint to listen on."""
    words = sys.argv[1:] if args is None else list(args)
    try:
        run_router(words[0] if words else None)
    except TeleopctlError as error:
        sys.stderr.write(f"{error.message}\n")
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())

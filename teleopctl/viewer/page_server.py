"""The web server of the page: viser's server behind the access rules of `base.access`."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import gc
import io
import logging
import socket
import threading
import warnings
from collections.abc import Iterator, Mapping
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.base.access import Access, Answer, host_in_url, is_loopback
from teleopctl.base.token_file import Address, default_token_file, read_or_make_token
from teleopctl.errors import TeleopctlError
from teleopctl.node import LogOnce

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

    from teleopctl.viewer.client_tracker import ClientTracker, PageServer
    from teleopctl.viewer.page_routes import PageRoutes

DEFAULT_PORT = 8080
_PORTS_TRIED = 20
_LAST_PORT = 65_535
_SILENT_MS = 30_000
# Send buffer of a connection. Messages in it are outdated when a browser reads them, so it holds
# about a second of a slow network. Linux doubles the value.
_WAITING_BYTES = 128 * 1024
_USER_TIMEOUT: int | None = getattr(socket, "TCP_USER_TIMEOUT", None)  # Linux only
_BRAND = (20, 120, 190)
# A page of another origin may neither show this page in a frame, which allows clickjacking, nor
# keep a reference to its window.
_FOR_ALL = {
    "Content-Security-Policy": "frame-ancestors 'self'",
    "X-Frame-Options": "SAMEORIGIN",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class PageError(TeleopctlError):
    """Error: the viewer's web page cannot be opened."""


def open_server(
    host: str = "127.0.0.1",
    port: int | None = None,
    *,
    token: str | None = None,
    routes: PageRoutes | None = None,
) -> PageServer:
    """Start the page's web server with access checks, and return it as a `PageServer`.

    Args:
        host: Address to listen on.
        port: Port to listen on; any free one for 0. None for 8080 or, if that is taken, the next
            free one of 20.
        token: Access token that the page's URL has to contain; required unless the host is
            loopback.
        routes: Further paths of the server, behind the same access checks; None for none.

    Raises:
        PageError: No port can be opened, or the required token is missing.
    """
    if token is None and not is_loopback(host):
        raise PageError(f"On {host} other machines can open the page: a token is required")
    port = _free_port(host, port)
    from teleopctl.viewer.client_tracker import ClientTracker, PageServer

    access, clients = Access(host, token), ClientTracker()

    # viser's warnings about values of another type quote the values.
    warnings.filterwarnings("ignore", r"\[viser\]", module=r"viser\.infra\._messages")
    client_errors = LogOnce(logging.getLogger(__name__).warning)
    with (
        _guarded(access, clients, client_errors, routes),
        contextlib.redirect_stdout(io.StringIO()),
    ):
        server = PageServer(host, port, clients, client_errors)
    set_events_in_server_thread(server)
    server.gui.configure_theme(
        show_logo=False,
        show_share_button=False,
        dark_mode=True,
        brand_color=_BRAND,
        control_width="large",
    )
    return server


def open_page(
    host: str,
    port: int | None = None,
    token_file: Path | None = None,
    *,
    routes: PageRoutes | None = None,
) -> tuple[PageServer, Address]:
    """Start the page's web server with the token of a file; return the server and its address.

    Args:
        host: Address to listen on.
        port: Port to listen on; see `open_server`.
        token_file: File of the page's token, created if missing. If None, `default_token_file` for
            a host other than loopback, else no token.
        routes: See `open_server`.

    Raises:
        TeleopctlError: The page cannot be opened, or the token cannot be read.
    """
    if token_file is None and not is_loopback(host):
        token_file = default_token_file()
    token_file = token_file and token_file.absolute()
    token = None if token_file is None else read_or_make_token(token_file)
    server = open_server(host, port, token=token, routes=routes)
    return server, page_address(host, server.get_port(), token_file)


def _free_port(host: str, port: int | None) -> int:
    """Return a port that is free; viser by itself would try a thousand, and then wait for ever."""
    if port is not None and not 0 <= port <= _LAST_PORT:
        raise PageError(f"There is no port {port}", hint=f"Ports range from 0 to {_LAST_PORT}.")
    last: OSError | None = None
    tried = range(DEFAULT_PORT, DEFAULT_PORT + _PORTS_TRIED) if port is None else (port,)
    for candidate in tried:
        try:
            family, _, _, _, address = socket.getaddrinfo(host, candidate, type=socket.SOCK_STREAM)[
                0
            ]
            with socket.create_server(address[:2], family=family):
                return candidate
        except OSError as error:
            last = error
    where = f"{host}:{tried[0]}"
    hint = "Without --port the next free port is taken." if port else None
    raise PageError(f"The page cannot be opened at {where}: {_reason(last)}", hint=hint)


def _reason(error: OSError | None) -> str:
    taken = error is not None and error.errno == errno.EADDRINUSE
    return "another program listens there" if taken else str(error)


_patching = threading.Lock()


@contextlib.contextmanager
def _guarded(
    access: Access, clients: ClientTracker, client_errors: LogOnce, routes: PageRoutes | None
) -> Iterator[None]:
    """Within the context, the server that viser starts checks each HTTP request before viser does.

    The access rules are checked first, then the routes, visibility reports and the page's version.
    An invalid message ends the browser's connection and is recorded as one of the client errors.

    viser offers no hook for requests, so `serve` of websockets is replaced within the context.
    """
    import websockets.asyncio.server as below

    serve = below.serve

    def guarded_serve(handler: Any, *args: Any, process_request: Any, **kwargs: Any) -> Any:
        def process(connection: ServerConnection, request: Request) -> Response | None:
            headers = {name.lower(): value for name, value in request.headers.raw_items()}
            answer = access.check(request.path, request.headers.raw_items())
            if answer is None and routes is not None and routes.has(request.path):
                return routes.respond(connection, request, _FOR_ALL)
            answer = (
                answer or clients.handle_request(request.path, headers) or _check_protocol(headers)
            )
            if answer is None and "upgrade" in headers and not clients.is_attached:
                # The browser tries again.
                answer = Answer(HTTPStatus.SERVICE_UNAVAILABLE, "The page is starting.\n")
            response: Response | None
            if answer is None:
                _limit_send_buffer(connection)
                try:
                    response = process_request(connection, request)
                except (OSError, ValueError):  # not a valid file name
                    response = connection.respond(HTTPStatus.NOT_FOUND, "There is no such file.\n")
            else:
                response = connection.respond(answer.status, answer.text)
                response.headers.update(answer.headers)
            if response is not None:
                response.headers.update(_FOR_ALL)
            return response

        if _USER_TIMEOUT is not None:
            kwargs["ping_timeout"] = None
        kwargs["logger"] = _logger_of(client_errors)
        asyncio.get_running_loop().set_exception_handler(
            lambda _loop, context: _note(client_errors, context.get("exception"))
        )
        chosen = handler if routes is None else routes.handler(handler)
        return serve(chosen, *args, process_request=process, **kwargs)

    with _patching:
        below.serve = guarded_serve  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            below.serve = serve  # type: ignore[misc]


class _ErrorHandler(logging.Handler):
    """Logging handler that records the server's connection errors, without traceback."""

    def __init__(self, client_errors: LogOnce) -> None:
        super().__init__(logging.WARNING)
        self._client_errors = client_errors

    def emit(self, record: logging.LogRecord) -> None:
        _note(self._client_errors, record.exc_info[1] if record.exc_info else None)


def _logger_of(client_errors: LogOnce) -> logging.Logger:
    """Return a logger, of this server alone, that records connection errors."""
    logger = logging.Logger("page", logging.WARNING)
    logger.addHandler(_ErrorHandler(client_errors))
    return logger


def _note(client_errors: LogOnce, error: BaseException | None) -> None:
    """Record an error in a browser's message by its type; its text may quote the message."""
    kind = "" if error is None else f" ({type(error).__name__})"
    client_errors.note(f"Invalid message from a browser{kind}")


def _check_protocol(headers: Mapping[str, str]) -> Answer | None:
    """Return a refusal for a websocket of another program or page version, else None."""
    import viser

    offered = headers.get("sec-websocket-protocol", "").split(",")
    if "upgrade" not in headers or f"viser-v{viser.__version__}" in map(str.strip, offered):
        return None
    return Answer(HTTPStatus.BAD_REQUEST, "The page has another version: reload it.\n")


def _limit_send_buffer(connection: ServerConnection) -> None:
    """Limit a connection's send buffer, and its time without an acknowledgement.

    viser replaces unsent messages by newer ones, but not those in the kernel's send buffer, which
    by default holds megabytes: a browser that reads slowly would lag behind.

    Pings of websockets wait behind unsent messages, so a ping timeout would end slow connections
    instead of dead ones. On Linux TCP_USER_TIMEOUT is used instead: it ends the connections of
    closed laptops and stopped browsers, for which the scene would still be drawn. Tabs that wake up
    reconnect.
    """
    below = connection.transport.get_extra_info("socket")
    below.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _WAITING_BYTES)
    if _USER_TIMEOUT is not None:
        below.setsockopt(socket.IPPROTO_TCP, _USER_TIMEOUT, _SILENT_MS)


def close_server(server: viser.ViserServer) -> None:
    """Stop the page's web server, without viser's printed messages."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def page_address(host: str, port: int, token_file: Path | None = None) -> Address:
    """Return the page's `Address`: its URL for a browser, and the file of its access token.

    Args:
        host: Address that the server listens on.
        port: Port of the server.
        token_file: File of the page's token; None for a page without token.
    """
    return Address(f"http://{host_in_url(host)}:{port}/", token_file)


class _LoopEvent(asyncio.Event):
    """asyncio event whose `set` has an effect in one thread only."""

    def __init__(self, thread: threading.Thread) -> None:
        super().__init__()
        self._thread = thread

    def set(self) -> None:
        """Set the event if called in the server's thread; do nothing in other threads."""
        if threading.current_thread() is self._thread:
            super().set()


def set_events_in_server_thread(server: viser.ViserServer) -> None:
    """Make viser set its message events in the server's thread alone.

    Drawing sets an event twice: directly, in the thread that draws, and by a call in the server's
    event loop. The direct call iterates over asyncio's waiters while the loop changes them, which
    at times raises "deque mutated during iteration" and has ended pages. The other call is enough.

    Args:
        server: The page's server, without connections yet.
    """
    below: Any = server._websock_server  # noqa: SLF001 -- viser has no public API
    thread = below._server_thread  # noqa: SLF001

    def replace_event(connection: Any) -> None:
        connection.get_message_buffer().message_event = _LoopEvent(thread)

    replace_event(below)
    below.on_client_connect(replace_event)


CLEANUP_PERIOD_S = 10.0
"""Period of `MemoryCleanup.run`."""

# viser reports a disconnect before it drops its own reference to the connection.
_COLLECTIONS_PER_DISCONNECT = 2


class MemoryCleanup:
    """Cleanup of memory held for closed browser connections and removed scene nodes.

    A closed connection leaves half a megabyte of objects in reference cycles. Python's garbage
    collector starts after a number of new objects that takes minutes or hours to reach here.

    viser keeps a removal message of each scene node for browsers that have not received it, and
    clears these messages only when another browser connects, which may be days later; a program
    that gives each marker a new name would fill the memory until then.

    Args:
        server: The page's server.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._collections_due = 0
        # viser's own callback leaves out browsers that have not sent their camera yet.
        server._websock_server.on_client_disconnect(self._disconnected)  # noqa: SLF001

    def run(self) -> None:
        """Clear viser's old messages, and collect garbage after a browser has disconnected."""
        server = self._server
        # In the server's thread, which also adds browsers.
        server._event_loop.call_soon_threadsafe(server._run_garbage_collector)  # noqa: SLF001
        if self._collections_due:
            self._collections_due -= 1
            gc.collect()

    def _disconnected(self, _connection: object) -> None:
        self._collections_due = _COLLECTIONS_PER_DISCONNECT

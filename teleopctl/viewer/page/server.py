"""Opens the page: viser's server behind our rules of access."""

from __future__ import annotations

import asyncio
import contextlib
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
from teleopctl.base.log_once import LogOnce
from teleopctl.base.token_file import Address
from teleopctl.errors import TeleopctlError
from teleopctl.viewer.page.audience import ClientTracker
from teleopctl.viewer.page.waking import wake_in_its_thread

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

    from teleopctl.viewer.page.page_server import PageServer

DEFAULT_PORT = 8080
_PORTS_TRIED = 20
_LAST_PORT = 65_535
_SILENT_MS = 30_000
# What waits in the kernel is old when it is read: a second of a slow network, and no more. Linux
# takes twice as much.
_WAITING_BYTES = 128 * 1024
_USER_TIMEOUT: int | None = getattr(socket, "TCP_USER_TIMEOUT", None)  # Linux has it
_BRAND = (20, 120, 190)
# No page of another origin may show this one in a frame, below buttons of its own, or keep hold of
# its window.
_FOR_ALL = {
    "Content-Security-Policy": "frame-ancestors 'self'",
    "X-Frame-Options": "SAMEORIGIN",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class PageError(TeleopctlError):
    """The page cannot be opened."""


def open_server(
    host: str = "127.0.0.1", port: int = DEFAULT_PORT, *, token: str | None = None
) -> PageServer:
    """Open the page's server.

    Args:
        host: The address to listen on.
        port: The port; one of the next if it is taken, any for 0.
        token: What the page's address has to carry; needed unless the host is loopback.

    Raises:
        PageError: Nothing can listen there, or a token is missing.
    """
    if token is None and not is_loopback(host):
        raise PageError(f"On {host} others could open the page: it needs a token")
    port = _free_port(host, port)
    access, audience = Access(host, token), ClientTracker()
    from teleopctl.viewer.page.page_server import PageServer

    # viser's words about values of another type, with the values in them.
    warnings.filterwarnings("ignore", r"\[viser\]", module=r"viser\.infra\._messages")
    mistakes = LogOnce(logging.getLogger(__name__).warning)
    with _guarded(access, audience, mistakes), contextlib.redirect_stdout(io.StringIO()):
        server = PageServer(host, port, audience, mistakes)
    wake_in_its_thread(server)
    server.gui.configure_theme(
        show_logo=False,
        show_share_button=False,
        dark_mode=True,
        brand_color=_BRAND,
        control_width="large",
    )
    return server


def _free_port(host: str, port: int) -> int:
    """Find a port; viser by itself would try a thousand, and then wait for ever."""
    if not 0 <= port <= _LAST_PORT:
        raise PageError(f"There is no port {port}", hint=f"Ports go from 0 to {_LAST_PORT}.")
    last: OSError | None = None
    for candidate in range(port, min(port + (_PORTS_TRIED if port else 1), _LAST_PORT + 1)):
        try:
            family, _, _, _, address = socket.getaddrinfo(host, candidate, type=socket.SOCK_STREAM)[
                0
            ]
            with socket.create_server(address[:2], family=family):
                return candidate
        except OSError as error:
            last = error
    raise PageError(f"The page cannot be opened at {host}:{port}: {last}")


_patching = threading.Lock()


@contextlib.contextmanager
def _guarded(access: Access, audience: ClientTracker, mistakes: LogOnce) -> Iterator[None]:
    """Have the server that viser starts meanwhile ask for access first, and then the audience.

    What browsers send that makes no sense ends their connection, and is noted among the mistakes.

    viser offers no way to look at requests. What it hands to the library below it does.
    """
    import websockets.asyncio.server as below

    serve = below.serve

    def guarded_serve(*args: Any, process_request: Any, **kwargs: Any) -> Any:
        def process(connection: ServerConnection, request: Request) -> Response | None:
            headers = {name.lower(): value for name, value in request.headers.raw_items()}
            answer = (
                access.check(request.path, request.headers.raw_items())
                or audience.take(request.path, headers)
                or _check_protocol(headers)
            )
            response: Response | None
            if answer is None:
                _bear_with_the_slow(connection)
                try:
                    response = process_request(connection, request)
                except (OSError, ValueError):  # a name that no file can have
                    response = connection.respond(HTTPStatus.NOT_FOUND, "There is no such file.\n")
            else:
                response = connection.respond(answer.status, answer.text)
                response.headers.update(answer.headers)
            if response is not None:
                response.headers.update(_FOR_ALL)
            return response

        if _USER_TIMEOUT is not None:
            kwargs["ping_timeout"] = None
        kwargs["logger"] = _logger_of(mistakes)
        asyncio.get_running_loop().set_exception_handler(
            lambda _loop, context: _note(mistakes, context.get("exception"))
        )
        return serve(*args, process_request=process, **kwargs)

    with _patching:
        below.serve = guarded_serve  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            below.serve = serve  # type: ignore[misc]


class _Noting(logging.Handler):
    """Notes what a server logs of its connections, without the traceback."""

    def __init__(self, mistakes: LogOnce) -> None:
        super().__init__(logging.WARNING)
        self._mistakes = mistakes

    def emit(self, record: logging.LogRecord) -> None:
        _note(self._mistakes, record.exc_info[1] if record.exc_info else None)


def _logger_of(mistakes: LogOnce) -> logging.Logger:
    """Return a logger of one server's own."""
    logger = logging.Logger("page", logging.WARNING)
    logger.addHandler(_Noting(mistakes))
    return logger


def _note(mistakes: LogOnce, error: BaseException | None) -> None:
    """Note what went wrong with a browser's message; its text is the sender's, and is left out."""
    kind = "" if error is None else f" ({type(error).__name__})"
    mistakes.note(f"A browser sent what makes no sense{kind}")


def _check_protocol(headers: Mapping[str, str]) -> Answer | None:
    """Refuse a websocket of another program, or of a page of another version."""
    import viser

    offered = headers.get("sec-websocket-protocol", "").split(",")
    if "upgrade" not in headers or f"viser-v{viser.__version__}" in map(str.strip, offered):
        return None
    return Answer(HTTPStatus.BAD_REQUEST, "The page is of another version: load it again.\n")


def _bear_with_the_slow(connection: ServerConnection) -> None:
    """Send what is new to a browser that reads slowly, and end the connection of one that is gone.

    viser replaces what has not been sent yet by what is newer; that holds only for what the kernel
    has not taken, which by itself would be megabytes.

    websockets asks whether the other end lives, but its question waits behind what is not taken: it
    would end slow connections and not silent ones. So where the kernel can tell, it is the one to
    ask: a closed lid and a stopped browser take nothing at all. As long as these count as browsers
    that look, everything is drawn for them. Tabs that wake up connect again by themselves.
    """
    below = connection.transport.get_extra_info("socket")
    below.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _WAITING_BYTES)
    if _USER_TIMEOUT is not None:
        below.setsockopt(socket.IPPROTO_TCP, _USER_TIMEOUT, _SILENT_MS)


def close_server(server: viser.ViserServer) -> None:
    """Close the page's server without viser's messages."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def page_address(host: str, port: int, token_file: Path | None = None) -> Address:
    """Return the address to open in a browser.

    Args:
        host: What the server listens on.
        port: Its port.
        token_file: Where the token is that the page asks for, if it asks for one.
    """
    return Address(f"http://{host_in_url(host)}:{port}/", token_file)

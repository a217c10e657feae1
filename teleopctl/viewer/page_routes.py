"""Further paths of the page's server: files and websockets of other packages."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response


@dataclass(frozen=True, slots=True)
class _File:
    content: bytes
    content_type: str


class PageRoutes:
    """Files and websockets by path, which the page's server offers beside the 3D view.

    Requests have passed the server's access checks. Add all routes before the server starts.

    Attributes:
        links: Titles of pages by path, see `add_link`.
    """

    def __init__(self) -> None:
        self._files: dict[str, _File] = {}
        self._sockets: dict[str, Callable[[ServerConnection], Awaitable[None]]] = {}
        self.links: dict[str, str] = {}

    def add_link(self, path: str, title: str) -> None:
        """Add a link to a path's page, which the page of the 3D view shows."""
        self.links[path] = title

    def add_file(self, path: str, content: bytes, content_type: str) -> None:
        """Add a file at a path such as ``/drive``."""
        self._files[path] = _File(content, content_type)

    def add_socket(self, path: str, handler: Callable[[ServerConnection], Awaitable[None]]) -> None:
        """Add a websocket at a path; the handler runs in the server's event loop."""
        self._sockets[path] = handler

    def has(self, path: str) -> bool:
        """Return whether there is a route for the path of a request, with its query."""
        return _plain(path) in self._files or _plain(path) in self._sockets

    def respond(
        self, connection: ServerConnection, request: Request, headers: Mapping[str, str]
    ) -> Response | None:
        """Return the response to a request of a route; None to open its websocket.

        Args:
            connection: Connection of the request.
            request: The request.
            headers: Headers of each response.
        """
        from websockets.datastructures import Headers
        from websockets.http11 import Response

        path = _plain(request.path)
        if path in self._sockets:
            if "upgrade" in {name.lower() for name, _ in request.headers.raw_items()}:
                return None
            return connection.respond(HTTPStatus.UPGRADE_REQUIRED, "This is a websocket.\n")
        file = self._files[path]
        own = {
            "Content-Type": file.content_type,
            "Content-Length": str(len(file.content)),
            "Cache-Control": "no-cache",
            **headers,
        }
        return Response(HTTPStatus.OK, HTTPStatus.OK.phrase, Headers(own), file.content)

    # Any: viser's handler of connections.
    def handler(self, others: Any) -> Callable[[ServerConnection], Awaitable[None]]:
        """Return a handler of connections: those of the routes' websockets, and all others.

        Args:
            others: Handler of the other connections.
        """

        async def handle(connection: ServerConnection) -> None:
            request = connection.request
            socket = None if request is None else self._sockets.get(_plain(request.path))
            await (others if socket is None else socket)(connection)

        return handle


def _plain(path: str) -> str:
    return path.partition("?")[0]

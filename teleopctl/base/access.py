"""Access rules of listening HTTP and WebSocket servers: Host, Origin and token.

A browser runs the scripts of every page that its user visits, and any script may open a connection
to this machine. So a request is admitted only if

- its ``Host`` is a loopback name or address: a foreign name that resolves to this machine (DNS
  rebinding) is refused. With a token any name is admitted, since no foreign page has the token;
- its ``Origin``, if any, is that of the server's own page, or one that the user has admitted.
  Browsers send the header with every WebSocket handshake, and no script can change it; other
  programs send none;
- it carries the token, where a token is required (always beyond loopback): in the query of the
  URL, or in the cookie that the server sets after such a query.
"""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import re
import socket
from collections.abc import Iterable
from http import HTTPStatus
from typing import NamedTuple
from urllib.parse import parse_qs, quote

FILE_ORIGIN = "file://"
"""The Origin of an Electron app whose pages are files, such as Foxglove's for the desktop."""

_DEFAULT_PORTS = {"http": 80, "https": 443}
# A label of a name, as in RFC 1123; names of containers also contain underscores.
_NAME = r"[a-z0-9_](?:[a-z0-9_-]*[a-z0-9_])?"
_AUTHORITY = re.compile(
    rf"(?P<host>\[[0-9a-f:.]+\]|{_NAME}(?:\.{_NAME})*\.?)(?::(?P<port>\d{{1,5}}))?"
)
_ORIGIN = re.compile(r"(?P<scheme>[a-z][a-z0-9+.-]*)://(?P<authority>[^/?#@\\]+)")
_COOKIE = "teleopctl"
# In characters. Paths of the web page's files are shorter; file systems end at 4096.
_LONGEST_PATH = 2048


class Answer(NamedTuple):
    """HTTP response that refuses or redirects a request.

    Attributes:
        status: HTTP status code.
        text: Body as plain text.
        headers: Headers in addition to Content-Length and Content-Type.
    """

    status: HTTPStatus
    text: str = ""
    headers: tuple[tuple[str, str], ...] = ()


class Access:
    """Access rules of one listening socket: Host, Origin and token.

    Args:
        host: The address that the server listens on.
        token: Token that clients must send; None is allowed only for loopback addresses.
        origins: Origins admitted in addition to the server's own page, in the form that
            `parse_origin` reads. `FILE_ORIGIN` admits Electron apps, not files that a browser
            shows.
    """

    def __init__(self, host: str, token: str | None = None, origins: Iterable[str] = ()) -> None:
        if token is None and not is_loopback(host):
            raise ValueError(f"a server on {host} needs a token")
        self._token = None if token is None else _bytes_of(token)
        self._origins = frozenset(map(parse_origin, origins))

    def check(self, path: str, headers: Iterable[tuple[str, str]]) -> Answer | None:
        """Return the response that refuses or redirects a request; None if access is granted.

        Args:
            path: Path and query of the request.
            headers: Names and values of the request's headers, as received.

        Returns:
            The response to send instead of the content, or None if the request is admitted.
        """
        values: dict[str, list[str]] = {}
        for name, value in headers:
            values.setdefault(name.lower(), []).append(value.strip())
        if len(path) > _LONGEST_PATH:
            return Answer(HTTPStatus.REQUEST_URI_TOO_LONG, "The address is too long.\n")
        hosts, origins = values.get("host", []), values.get("origin", [])
        if len(hosts) != 1 or len(origins) > 1 or (host := _authority(hosts[0])) is None:
            return Answer(
                HTTPStatus.BAD_REQUEST, "A request has one Host header, and one Origin at most.\n"
            )
        if self._token is None and not is_loopback(host[0]):
            return _refused(f"This server is at localhost, not at {hosts[0]}.")
        if origins and not self._admits(origins[0], hosts[0], values.get("user-agent", [])):
            return _refused(f"Pages from {origins[0] or 'nowhere'} may not access this address.")
        if self._token is None:
            return None
        return self._check_token(path, values, self._token)

    def _admits(self, origin: str, host: str, user_agent: list[str]) -> bool:
        if origin == FILE_ORIGIN:
            # Scripts cannot change User-Agent; a browser that shows a local file is not Electron.
            return FILE_ORIGIN in self._origins and any("Electron/" in name for name in user_agent)
        try:
            known = parse_origin(origin)
        except ValueError:
            return False
        scheme = known.partition(":")[0]
        return known in self._origins or (
            scheme in _DEFAULT_PORTS
            and _authority(known.partition("//")[2], scheme) == _authority(host, scheme)
        )

    def _check_token(self, path: str, values: dict[str, list[str]], token: bytes) -> Answer | None:
        given = parse_qs(path.partition("?")[2]).get("token", [])
        if len(given) == 1 and hmac.compare_digest(_bytes_of(given[0]), token):
            if any(value.lower() == "websocket" for value in values.get("upgrade", [])):
                return None
            name, value = _cookie_of(token)
            # Not Strict: browsers would not send the cookie after a click on a link in a mail.
            cookie = f"{name}={value}; HttpOnly; SameSite=Lax; Path=/"
            # Of the same server: `//host` would be another one.
            page = "/" + path.partition("?")[0].lstrip("/\\")
            return Answer(HTTPStatus.FOUND, "", (("Location", page), ("Set-Cookie", cookie)))
        if _has_cookie(values.get("cookie", []), *_cookie_of(token)):
            return None
        return _refused("Open the address that the program printed, with its token.")


def is_loopback(host: str) -> bool:
    """Return whether a host name or address is a loopback one."""
    if host.lower().removesuffix(".") == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def host_in_url(host: str) -> str:
    """Return the host for URLs of a listen address: localhost, for a wildcard the host name."""
    if is_loopback(host):
        return "localhost"
    if host in ("0.0.0.0", "::"):  # noqa: S104 -- compared, not bound
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host


def parse_origin(text: str) -> str:
    """Return an Origin normalized to lower case without default port; raise if it is none.

    Raises:
        ValueError: The text is not an origin. ``null`` is refused, since any page can send it.
    """
    lowered = text.lower()
    if lowered == FILE_ORIGIN:
        return FILE_ORIGIN
    match = _ORIGIN.fullmatch(lowered)
    authority = match and _authority(match["authority"], match["scheme"])
    if not match or authority is None:
        raise ValueError(
            f"'{text}' is not an origin: expected a scheme, a host and optionally a port"
        )
    host, port = authority
    name = f"[{host}]" if ":" in host else host
    is_default = port is None or _DEFAULT_PORTS.get(match["scheme"]) == port
    return f"{match['scheme']}://{name}" + ("" if is_default else f":{port}")


def with_token(address: str, token: str) -> str:
    """Return a URL with ``?token=`` and the access token appended."""
    return f"{address}?token={quote(token, safe='')}"


def _authority(text: str, scheme: str = "") -> tuple[str, int | None] | None:
    """Host and port of a ``Host`` header or an origin; None for anything else."""
    match = _AUTHORITY.fullmatch(text.lower())
    if match is None:
        return None
    host = match["host"]
    if host.startswith("["):
        try:
            host = str(ipaddress.IPv6Address(host[1:-1]))
        except ValueError:
            return None
    port = int(match["port"]) if match["port"] else _DEFAULT_PORTS.get(scheme)
    return None if port is not None and port > 0xFFFF else (host, port)


def _bytes_of(text: str) -> bytes:
    # Non-ASCII bytes of a request are lone surrogates in its text, one for each byte.
    try:
        return text.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        return b""


def _cookie_of(token: bytes) -> tuple[str, str]:
    """Name and value of the cookie that stands for a token.

    Cookies allow few characters and are shared by all ports of a host. So name and value are parts
    of a digest, and servers with different tokens have different cookies.
    """
    digest = hmac.new(token, b"teleopctl cookie", hashlib.sha256).hexdigest()
    return f"{_COOKIE}-{digest[:8]}", digest[8:]


def _has_cookie(headers: list[str], name: str, value: str) -> bool:
    # Not http.cookies, which drops all cookies of a host if one of them is malformed.
    pairs = (part.strip().partition("=") for header in headers for part in header.split(";"))
    given = [_bytes_of(text) for known, _, text in pairs if known == name]
    return any(hmac.compare_digest(each, value.encode()) for each in given)


def _refused(why: str) -> Answer:
    return Answer(HTTPStatus.FORBIDDEN, f"{why}\n")

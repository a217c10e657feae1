"""Who may open the page: people on this machine, and with the token those from elsewhere.

A browser runs the scripts of every page that its user visits, and any of them may open a
connection to this machine. So each request has to come from the page itself:

- ``Host`` names this machine; a foreign name that resolves to it (DNS rebinding) is refused.
- ``Origin``, where the browser sends one, is that host. Browsers send it with every websocket.
- Beyond loopback a token is needed: the page's address carries it once, a cookie from then on.
"""

from __future__ import annotations

import hmac
import ipaddress
from collections.abc import Mapping
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import NamedTuple
from urllib.parse import parse_qs, urlsplit

_COOKIE = "teleopctl"


class Answer(NamedTuple):
    """An answer in the place of the page.

    Attributes:
        status: Its HTTP status.
        text: The body, as plain text.
        headers: Headers beside that of its length and type.
    """

    status: HTTPStatus
    text: str = ""
    headers: tuple[tuple[str, str], ...] = ()


class Access:
    """Decides on requests.

    Args:
        host: The address that the server listens on.
        token: What the address of the page has to carry; None is for loopback only.
    """

    def __init__(self, host: str, token: str | None = None) -> None:
        if token is None and not is_loopback(host):
            raise ValueError(f"a page on {host} needs a token")
        self._token = token

    def check(self, path: str, headers: Mapping[str, str]) -> Answer | None:
        """Decide on one request.

        Args:
            path: Path and query of the request.
            headers: Its headers, by names in small letters; the last one of several counts.

        Returns:
            What to answer instead of the page, or None for whoever may see it.
        """
        host = headers.get("host", "")
        if self._token is None and not is_loopback(_name_of(host)):
            return _refused(
                f"This page is at localhost, and not at {host or 'a host without name'}."
            )
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return _refused(f"Pages from {origin} may not talk to this one.")
        if self._token is None:
            return None
        url = urlsplit(path)
        given = parse_qs(url.query).get("token", [""])[0]
        if given and self._is_token(given):
            cookie = f"{_COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/"
            return Answer(HTTPStatus.FOUND, "", (("Location", url.path), ("Set-Cookie", cookie)))
        if self._is_token(_cookie(headers.get("cookie", ""))):
            return None
        return _refused("Open the address that the program printed, with its token.")

    def _is_token(self, text: str) -> bool:
        assert self._token is not None
        return hmac.compare_digest(text.encode(), self._token.encode())


def is_loopback(host: str) -> bool:
    """Whether a host's name or address means this machine and can be reached from nowhere else."""
    if host.lower().rstrip(".") == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _name_of(host: str) -> str:
    """The host of a ``Host`` header, without its port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _cookie(header: str) -> str:
    try:
        morsel = SimpleCookie(header).get(_COOKIE)
    except CookieError:
        return ""
    return "" if morsel is None else morsel.value


def _refused(why: str) -> Answer:
    return Answer(HTTPStatus.FORBIDDEN, f"{why}\n")

"""Who has the page before his eyes, and who has it in a tab behind or in a hidden window.

viser's browser side reads on in a worker, which no browser slows down, and tells neither. So every
browser is given a script that does, with a request to the page's own address:

    GET /visibility
    Teleopctl-Browser: 3
    Teleopctl-Visibility: hidden

The number is viser's, anew for each connection. Browsers send headers of such names to the page
that they are from, and to others only with their leave, which nobody is given here: so no foreign
page can tell. Whoever tells nothing looks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from http import HTTPStatus
from typing import TYPE_CHECKING

from teleopctl.base.access import Answer

if TYPE_CHECKING:
    import viser

_PATH = "/visibility"
_BROWSER, _VISIBILITY = "teleopctl-browser", "teleopctl-visibility"

# One request at a time, so that none overtakes another; what has changed meanwhile is told by the
# next. After a new connection the script of the former one has nothing to tell any more.
_SCRIPT = """
const browser = "%d";
let told = "visible";
let telling = false;
window.teleopctlBrowser = browser;
document.onvisibilitychange = async () => {
  if (telling) return;
  telling = true;
  while (told !== document.visibilityState && window.teleopctlBrowser === browser) {
    const visibility = document.visibilityState;
    const headers = {"Teleopctl-Browser": browser, "Teleopctl-Visibility": visibility};
    try {
      await fetch("visibility", {headers, cache: "no-store", keepalive: true});
      told = visibility;
    } catch {
      await new Promise((again) => setTimeout(again, 1000));
    }
  }
  telling = false;
};
document.onvisibilitychange();
"""


class ClientTracker:
    """Keeps track of the browsers that have the page open, and whether they show it."""

    def __init__(self) -> None:
        self._shows: dict[int, bool] = {}
        self._changed: list[Callable[[], object]] = []

    def follow(self, server: viser.ViserServer) -> None:
        """Have each new browser report whether it shows the page.

        Args:
            server: The page's server.
        """
        from viser._messages import RunJavascriptMessage
        from viser.infra import WebsockClientConnection

        below = server._websock_server  # noqa: SLF001 -- by itself viser tells of them later

        def ask(connection: WebsockClientConnection) -> None:
            self._shows[connection.client_id] = True
            connection.queue_message(RunJavascriptMessage(_SCRIPT % connection.client_id))

        def forget(connection: WebsockClientConnection) -> None:
            self._shows.pop(connection.client_id, None)

        below.on_client_connect(ask)
        below.on_client_disconnect(forget)

    def on_change(self, callback: Callable[[], object]) -> None:
        """Call a function, in the server thread, when a browser shows or hides the page."""
        self._changed.append(callback)

    def looks(self, browser: int) -> bool:
        """Return whether a browser shows the page.

        Args:
            browser: viser's number of it.
        """
        return self._shows.get(browser, True)

    def take(self, path: str, headers: Mapping[str, str]) -> Answer | None:
        """Handle a browser's visibility report; return None for any other request.

        Args:
            path: Path and query of the request.
            headers: Its headers, by names in small letters.
        """
        if path != _PATH or not {_BROWSER, _VISIBILITY} <= headers.keys():
            return None
        shows = headers[_VISIBILITY] != "hidden"
        for browser in self._shows:
            if str(browser) == headers[_BROWSER]:
                self._shows[browser] = shows
        for callback in self._changed:
            callback()
        return Answer(HTTPStatus.OK)

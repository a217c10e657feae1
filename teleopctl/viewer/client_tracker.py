"""The browsers that have the page open, and viser's server that keeps track of them.

viser's client reads messages in a web worker, which browsers do not slow down in hidden tabs, and
does not report whether the page is visible. So the server sends each browser a script that reports
the visibility, with a request to the page's own address:

    GET /visibility
    Teleopctl-Browser: 3
    Teleopctl-Visibility: hidden

The number is viser's client ID, a new one for each connection. Browsers send custom headers only to
the page's own origin (other origins need a CORS permission, which this server never gives), so no
foreign page can send a report. The page counts as visible until a report arrives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from http import HTTPStatus

import viser

from teleopctl.base.access import Answer
from teleopctl.node import LogOnce

_PATH = "/visibility"
_BROWSER, _VISIBILITY = "teleopctl-browser", "teleopctl-visibility"

# One request at a time, so that none overtakes another; a change during a request is sent by the
# next one. After a reconnect the script of the former connection sends nothing more.
_SCRIPT = """
const browser = "%d";
let reported = "visible";
let sending = false;
window.teleopctlBrowser = browser;
document.onvisibilitychange = async () => {
  if (sending) return;
  sending = true;
  while (reported !== document.visibilityState && window.teleopctlBrowser === browser) {
    const visibility = document.visibilityState;
    const headers = {"Teleopctl-Browser": browser, "Teleopctl-Visibility": visibility};
    try {
      await fetch("visibility", {headers, cache: "no-store", keepalive: true});
      reported = visibility;
    } catch {
      await new Promise((again) => setTimeout(again, 1000));
    }
  }
  sending = false;
};
document.onvisibilitychange();
"""


class ClientTracker:
    """Record of the browsers connected to the page, and whether the page is visible in each."""

    def __init__(self) -> None:
        self._visible: dict[int, bool] = {}
        self._changed: list[Callable[[], object]] = []

    def attach(self, server: viser.ViserServer) -> None:
        """Track a server's connecting browsers, and send each the script that reports visibility.

        Args:
            server: The page's server.
        """
        from viser._messages import RunJavascriptMessage
        from viser.infra import WebsockClientConnection

        below = server._websock_server  # noqa: SLF001 -- viser's public callbacks are called later

        def add(connection: WebsockClientConnection) -> None:
            self._visible[connection.client_id] = True
            connection.queue_message(RunJavascriptMessage(_SCRIPT % connection.client_id))

        def remove(connection: WebsockClientConnection) -> None:
            self._visible.pop(connection.client_id, None)

        below.on_client_connect(add)
        below.on_client_disconnect(remove)

    def on_change(self, callback: Callable[[], object]) -> None:
        """Register a callback for each visibility report; called on the server's thread."""
        self._changed.append(callback)

    def is_visible(self, browser: int) -> bool:
        """Return whether the page is visible in a browser (client ID); True without a report.

        Args:
            browser: viser's client ID.
        """
        return self._visible.get(browser, True)

    def handle_request(self, path: str, headers: Mapping[str, str]) -> Answer | None:
        """Store a visibility report, call the callbacks, and return HTTP 200; else return None.

        Args:
            path: Path and query of the request.
            headers: The request's headers, by lower-case names.
        """
        if path != _PATH or not {_BROWSER, _VISIBILITY} <= headers.keys():
            return None
        visible = headers[_VISIBILITY] != "hidden"
        for browser in self._visible:
            if str(browser) == headers[_BROWSER]:
                self._visible[browser] = visible
        for callback in self._changed:
            callback()
        return Answer(HTTPStatus.OK)


class PageServer(viser.ViserServer):
    """viser's web server for the page, which tracks connected browsers by a `ClientTracker`.

    Args:
        host: Address to listen on.
        port: Port to listen on; 0 for any free one.
        clients: Tracker to which `open_server` passes the visibility reports.
        client_errors: Log in which `open_server` records errors in browsers' messages.

    Attributes:
        clients: Tracker of the browsers that have the page open.
        client_errors: Log of invalid messages from browsers, each kind once; its target is
            `LogOnce.log`.
    """

    def __init__(
        self, host: str, port: int, clients: ClientTracker, client_errors: LogOnce
    ) -> None:
        super().__init__(host, port, verbose=False)
        self.clients = clients
        self.client_errors = client_errors
        clients.attach(self)

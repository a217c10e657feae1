"""The browsers that have the page open, and viser's server that keeps track of them.

viser's client reads messages in a web worker, which browsers do not slow down in hidden tabs, and
reports neither whether the page is visible nor which panels are. So the server sends each browser
a script that reports both, with a request to the page's own address:

    GET /visibility
    Teleopctl-Browser: 3
    Teleopctl-Visibility: hidden
    Teleopctl-Panels: camera plot
    Teleopctl-Embedded: false

A page is embedded in that of ``/drive``, which shows the 3D view alone. Elements of a panel's HTML
that answer to a click carry what is clicked (see `click_mark`); the script reports it in the same
way:

    GET /click
    Teleopctl-Browser: 3
    Teleopctl-Click: graph%20node%20%2Ftalker

The number is viser's client ID, a new one for each connection. Browsers send custom headers only to
the page's own origin (other origins need a CORS permission, which this server never gives), so no
foreign page can send a report. Until a report arrives the page counts as visible, and its panels do
not.
"""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import unquote

import viser

from teleopctl.base.access import Answer
from teleopctl.node import LogOnce
from teleopctl.viewer import page_style

_PATH, _CLICK_PATH = "/visibility", "/click"
_BROWSER, _VISIBILITY = "teleopctl-browser", "teleopctl-visibility"
_PANELS, _EMBEDDED = "teleopctl-panels", "teleopctl-embedded"
_CLICK = "teleopctl-click"
_LONGEST_REPORT = 2000

RECORDED_LABEL, RECORDED_TIME = "s of the bag", "teleopctl-recorded-time"
"""Label of the time axis of plots of a recording, and ID of the element with its present time.

The page's script sets the cursor of these plots to that time.
"""

# A panel's content starts with an element that has the panel's name, see `panel_mark`. What stands
# around the element is hidden with the panel: by another tab, a minimized column, a closed section.
# One request at a time, so that none overtakes another; a change during a request is sent by the
# next one. After a reconnect the script of the former connection sends nothing more.
_SCRIPT = """
const browser = "%d";
let reported = "";
let sending = false;
window.teleopctlBrowser = browser;
const isShown = (mark) => {
  if (!mark.parentElement.checkVisibility({visibilityProperty: true})) return false;
  for (let box = mark.parentElement.parentElement; box; box = box.parentElement) {
    const {width, height} = box.getBoundingClientRect();
    if (width < 4 || height < 4) return false;
  }
  return true;
};
const shownPanels = () => {
  const marks = [...document.querySelectorAll("[data-teleopctl-panel]")];
  const names = marks.filter(isShown).map((mark) => mark.dataset.teleopctlPanel);
  return [...new Set(names)].sort().join(" ");
};
const report = async () => {
  if (sending) return;
  sending = true;
  while (window.teleopctlBrowser === browser) {
    const visibility = document.visibilityState;
    const panels = visibility === "hidden" ? "" : shownPanels();
    if (reported === visibility + panels) break;
    const headers = {
      "Teleopctl-Browser": browser,
      "Teleopctl-Visibility": visibility,
      "Teleopctl-Panels": panels,
      "Teleopctl-Embedded": window.parent !== window,
    };
    try {
      const signal = AbortSignal.timeout(5000);
      await fetch("visibility", {headers, signal, cache: "no-store", keepalive: true});
      reported = visibility + panels;
    } catch {
      await new Promise((again) => setTimeout(again, 1000));
    }
  }
  sending = false;
};
// The legends of plots show the newest values while the mouse is elsewhere; those of a recording
// have the cursor at its time.
const fillLegends = () => {
  const now = parseFloat(document.getElementById("%s")?.textContent);
  for (const {chart} of Object.values(window.__viserTestpoints?.uplots ?? {})) {
    if (chart.series[0].label === "%s") {
      if (isNaN(now) || chart.over.matches(":hover")) continue;
      const left = chart.valToPos(now, "x");
      chart.setCursor({left: left <= chart.over.clientWidth ? left : -10, top: -10});
    } else if (chart.cursor.left < 0 && chart.data?.[0]?.length) {
      chart.setLegend({idx: chart.data[0].length - 1});
    }
  }
};
// In the capture phase, since a clickable element may lie in a label that has a use of its own.
// If a table is redrawn between press and release, the browser reports no click: the release is
// then taken as one if the element under the pointer has the mark that was pressed.
const markOf = (element) =>
  element?.closest?.("[data-teleopctl-click]")?.dataset.teleopctlClick ?? "";
const sendClick = (mark) => {
  const headers = {"Teleopctl-Browser": browser, "Teleopctl-Click": encodeURIComponent(mark)};
  fetch("click", {headers, cache: "no-store"}).catch(() => {});
};
let pressed = "";
const listeners = {
  pointerdown: ({target}) => { pressed = markOf(target); },
  pointerup: ({clientX, clientY}) => {
    const mark = pressed;
    if (!mark || markOf(document.elementFromPoint(clientX, clientY)) !== mark) return;
    setTimeout(() => { if (pressed === mark) { pressed = ""; sendClick(mark); } }, 100);
  },
  click: (event) => {
    const mark = markOf(event.target);
    if (!mark) return;
    event.preventDefault();
    event.stopPropagation();
    pressed = "";
    sendClick(mark);
  },
  keydown: ({key}) => {  // closes the window that was opened last
    const buttons = [...document.querySelectorAll(".mantine-Modal-content button")];
    const close = buttons.filter((button) => button.textContent.trim() === "Close").at(-1);
    if (key === "Escape") close?.click();
  },
};
for (const [kind, listener] of Object.entries(listeners)) {
  document.removeEventListener(kind, window.teleopctlListeners?.[kind], true);
  document.addEventListener(kind, listener, true);
}
window.teleopctlListeners = listeners;
// A click on a list to type in marks its text, so that what is typed takes its place.
document.removeEventListener("click", window.teleopctlMark);
window.teleopctlMark = ({target}) => {
  if (target.matches?.("input.mantine-Select-input") && !target.readOnly) target.select();
};
document.addEventListener("click", window.teleopctlMark);
document.onvisibilitychange = report;
report();
clearInterval(window.teleopctlReports);
window.teleopctlReports = setInterval(() => {
  report();
  if (document.visibilityState !== "hidden") fillLegends();
}, 250);
"""


def _script(client_id: int) -> str:
    return _SCRIPT % (client_id, RECORDED_TIME, RECORDED_LABEL)


# The browser's tab: the page's name, and an arm in its colour.
_NAME = "teleopctl"
_ICON = (
    "data:image/svg+xml,"
    "%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 32 32' fill='none' stroke='%231478be' "
    "stroke-width='4' stroke-linecap='round' stroke-linejoin='round'%3E"
    "%3Cpath d='M6 29h12M12 28V15L22 7l6 5M28 12v5'/%3E%3C/svg%3E"
)
_TITLE = """
document.title = %s;
const links = [...document.querySelectorAll("link[rel~=icon]")];
const link = links[0] ?? document.head.appendChild(document.createElement("link"));
links.slice(1).forEach((other) => other.remove());
Object.assign(link, {rel: "icon", type: "image/svg+xml", href: %s});
"""


def panel_mark(name: str) -> str:
    """Return the HTML of the element by which a browser finds a panel, first in its content.

    Args:
        name: Name of the panel in the registry.
    """
    return f'<span data-teleopctl-panel="{name}"></span>'


def click_mark(panel: str, what: str) -> str:
    """Return the attributes of an HTML or SVG element whose clicks a panel receives.

    Args:
        panel: Name of the panel in the registry, whose `Panel.clicked` is called.
        what: Text that the panel is called with.
    """
    return f'data-teleopctl-click="{html.escape(f"{panel} {what}")}" style="cursor:pointer"'


_FILL = """
for (const [id, text] of Object.entries(%s)) {
  const element = document.getElementById(id);
  if (element) element.textContent = text;
}
"""
# A tab is chosen by the keyboard, since viser's tabs do not answer to a click without a pointer. On
# a phone it is in a section of the sheet, which names its tabs.
_SHOW_TAB = """
const [panel, title] = %s;
const all = (selector) => [...document.querySelectorAll(selector)];
all(".graph-large").forEach((box) => { box.checked = false; });
const names = (element) => element.textContent.split("\u00b7").map((name) => name.trim());
all("[role=button][aria-expanded=false]").find((one) => names(one).includes(title))?.click();
setTimeout(() => {
  const tab = all("[role=tab]").find((one) => one.textContent.trim() === title);
  tab?.focus();
  tab?.dispatchEvent(new KeyboardEvent("keydown", {key: "Enter", bubbles: true}));
  setTimeout(() => {
    const mark = document.querySelector(`[data-teleopctl-panel="${panel}"]`);
    mark?.parentElement.scrollIntoView({block: "start"});
  }, 300);
}, 300);
"""


@dataclass
class _Sight:
    """Last report of a browser about its page.

    Attributes:
        is_visible: Whether the page is visible.
        is_embedded: Whether the page is embedded in that of ``/drive``, and has no panels.
        panels: Names of the visible panels.
        is_reported: Whether there has been a report.
    """

    is_visible: bool = True
    is_embedded: bool = False
    panels: frozenset[str] = frozenset()
    is_reported: bool = False


class ClientTracker:
    """Record of the browsers connected to the page, and what is visible in each.

    Attributes:
        is_attached: Whether browsers may connect. viser listens before it takes note of browsers:
            one that connects in between, as soon as a page is started again, would stay unknown.
    """

    def __init__(self) -> None:
        self.is_attached = False
        self._sights: dict[int, _Sight] = {}
        self._changed: list[Callable[[], object]] = []
        self._clicked: list[Callable[[int, str, str], object]] = []

    def attach(self, server: viser.ViserServer) -> None:
        """Track a server's connecting browsers, and send each the script that reports visibility.

        Args:
            server: The page's server.
        """
        from viser._messages import RunJavascriptMessage
        from viser.infra import WebsockClientConnection

        below = server._websock_server  # noqa: SLF001 -- viser's public callbacks are called later

        def add(connection: WebsockClientConnection) -> None:
            self._sights[connection.client_id] = _Sight()
            connection.queue_message(RunJavascriptMessage(_script(connection.client_id)))

        def remove(connection: WebsockClientConnection) -> None:
            self._sights.pop(connection.client_id, None)

        below.on_client_connect(add)
        below.on_client_disconnect(remove)
        self.is_attached = True

    def on_change(self, callback: Callable[[], object]) -> None:
        """Register a callback for each visibility report; called on the server's thread."""
        self._changed.append(callback)

    def on_click(self, callback: Callable[[int, str, str], object]) -> None:
        """Register a callback for clicks on elements with a `click_mark`.

        Args:
            callback: Called on the server's thread with viser's client ID, the panel's name and
                the text of the mark.
        """
        self._clicked.append(callback)

    def is_visible(self, browser: int) -> bool:
        """Return whether the page is visible in a browser (client ID); True without a report.

        Args:
            browser: viser's client ID.
        """
        sight = self._sights.get(browser)
        return sight is None or sight.is_visible

    def is_embedded(self, browser: int) -> bool:
        """Return whether a browser shows the 3D view alone, in a page around it.

        Args:
            browser: viser's client ID.
        """
        sight = self._sights.get(browser)
        return sight is not None and sight.is_embedded

    def panels_in(self, browser: int) -> frozenset[str]:
        """Return the names of the panels that are visible in one browser.

        Args:
            browser: viser's client ID.
        """
        sight = self._sights.get(browser)
        return sight.panels if sight is not None else frozenset()

    def visible_panels(self) -> frozenset[str]:
        """Return the names of the panels that are visible in at least one browser."""
        return frozenset().union(*(sight.panels for sight in tuple(self._sights.values())))

    def awaits_report(self, browsers: Iterable[int]) -> bool:
        """Return whether one of the browsers has not reported its panels yet.

        Args:
            browsers: viser's client IDs of those that are connected.
        """
        sights = (self._sights.get(browser) for browser in browsers)
        return any(sight is not None and not sight.is_reported for sight in sights)

    def handle_request(self, path: str, headers: Mapping[str, str]) -> Answer | None:
        """Store a report of visibility or of a click, and return HTTP 200; else return None.

        Args:
            path: Path and query of the request.
            headers: The request's headers, by lower-case names.
        """
        if path == _CLICK_PATH and {_BROWSER, _CLICK} <= headers.keys():
            panel, _, what = unquote(headers[_CLICK][:_LONGEST_REPORT]).partition(" ")
            for browser in tuple(self._sights):
                if str(browser) == headers[_BROWSER]:
                    for clicked in self._clicked:
                        clicked(browser, panel, what)
            return Answer(HTTPStatus.OK)
        if path != _PATH or not {_BROWSER, _VISIBILITY} <= headers.keys():
            return None
        visible = headers[_VISIBILITY] != "hidden"
        panels = frozenset(headers.get(_PANELS, "")[:_LONGEST_REPORT].split())
        for browser, sight in self._sights.items():
            if str(browser) == headers[_BROWSER]:
                sight.is_visible, sight.panels = visible, panels if visible else frozenset()
                sight.is_embedded = headers.get(_EMBEDDED) == "true"
                sight.is_reported = True
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
        from viser._messages import RunJavascriptMessage

        super().__init__(host, port, verbose=False)
        self.clients = clients
        self.client_errors = client_errors
        clients.attach(self)
        self._websock_server.queue_message(RunJavascriptMessage(page_style.SCRIPT))
        self.set_title("")

    def notify(
        self, title: str, text: str = "", *, wrong: bool = False, browser: int | None = None
    ) -> None:
        """Show a notification for 8 s.

        Args:
            title: Title of the notification.
            text: Text below it.
            wrong: Whether it tells of an error, and is red.
            browser: viser's client ID of the browser; None for all browsers.
        """
        for number, client in self.get_clients().items():
            if browser in (None, number):
                client.add_notification(
                    title, text, color="red" if wrong else None, auto_close_seconds=8.0
                )

    def fill(self, texts: Mapping[str, str], *, browser: int | None = None) -> None:
        """Set the text of elements of the page's HTML.

        So a value changes without the HTML around it being sent and made again.

        Args:
            texts: New texts, by ID of the element; elements that are not there are left out.
            browser: viser's client ID of the browser; None for all browsers.
        """
        script = _FILL % json.dumps(dict(texts)).replace("<", "\\u003c")
        for one in self.get_clients() if browser is None else (browser,):
            self.run_script(one, script)

    def run_script(self, browser: int, script: str) -> None:
        """Run a script in one browser.

        Args:
            browser: viser's client ID.
            script: The script, in JavaScript.
        """
        from viser._messages import RunJavascriptMessage

        client = self.get_clients().get(browser)
        if client is not None:
            connection = client._websock_connection  # noqa: SLF001 -- viser has no public API
            connection.queue_message(RunJavascriptMessage(script))

    def show_tab(self, browser: int, panel: str, title: str) -> None:
        """Bring the tab of a panel to the front in one browser; viser's interface cannot.

        Args:
            browser: viser's client ID.
            panel: Name of the panel in the registry.
            title: Title of the panel's tab.
        """
        self.run_script(browser, _SHOW_TAB % json.dumps([panel, title]))

    def set_title(self, title: str) -> None:
        """Set the title of the browser's tab, with the page's name after it, and its icon.

        Args:
            title: Name of the robot; empty for the page's name alone.
        """
        from viser._messages import RunJavascriptMessage

        text = f"{title} · {_NAME}" if title else _NAME
        script = _TITLE % (json.dumps(text), json.dumps(_ICON))
        self._websock_server.queue_message(RunJavascriptMessage(script))

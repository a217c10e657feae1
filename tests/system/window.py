"""Window of Chromium that can be covered; pages of Playwright are always visible."""

from __future__ import annotations

import json
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import connect
from websockets.sync.connection import Connection

from teleopctl.testing import LONGEST_WAIT_S, eventually
from tests.system.browser import LITTLE_TO_COMPOSE, SOFTWARE_GL, chromium_program


class Window:
    """Window of Chromium with one tab.

    Args:
        tab: WebSocket connection to the tab, for the Chrome DevTools Protocol.
    """

    def __init__(self, tab: Connection) -> None:
        self._tab = tab
        self._sent = 0

    def cover(self) -> None:
        """Open another tab in front, which hides the page."""
        self._do("Target.createTarget", url="about:blank")

    def uncover(self) -> None:
        """Bring the tab to the front."""
        self._do("Page.bringToFront")

    def _do(self, method: str, **parameters: object) -> Any:
        self._sent += 1
        self._tab.send(json.dumps({"id": self._sent, "method": method, "params": parameters}))
        while (answer := json.loads(self._tab.recv(LONGEST_WAIT_S))).get("id") != self._sent:
            pass
        return answer["result"]


@contextmanager
def window(address: str, folder: Path) -> Iterator[Window]:
    """Open a page in a new window; skip the test if Chromium is not installed.

    Args:
        address: URL of the page.
        folder: Folder for the browser's profile.
    """
    words = ["--headless=new", "--no-sandbox", "--window-size=400,300", *SOFTWARE_GL]
    words += LITTLE_TO_COMPOSE
    words += ["--remote-debugging-port=0", f"--user-data-dir={folder}", address]
    with subprocess.Popen([chromium_program(), *words], stderr=subprocess.DEVNULL) as browser:
        try:
            eventually(lambda: _tabs_of(address, folder))
            with connect(_tabs_of(address, folder)[0], max_size=None) as tab:
                yield Window(tab)
        finally:
            browser.terminate()


def _tabs_of(address: str, folder: Path) -> list[str]:
    """Return the WebSocket debugger URLs of the tabs with a page; empty before there is one."""
    port = folder / "DevToolsActivePort"
    if not port.is_file() or not (lines := port.read_text().splitlines()):
        return []
    with urllib.request.urlopen(f"http://127.0.0.1:{lines[0]}/json") as answer:
        return [tab["webSocketDebuggerUrl"] for tab in json.load(answer) if tab["url"] == address]

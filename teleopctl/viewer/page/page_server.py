"""viser's server, which also knows who looks."""

from __future__ import annotations

import viser

from teleopctl.base.log_once import LogOnce
from teleopctl.viewer.page.audience import ClientTracker


class PageServer(viser.ViserServer):
    """viser server with the page's access checks; see `open_server`.

    Args:
        host: The address to listen on.
        port: The port; any for 0.
        audience: Hears of the requests that it takes; the server does not ask it.
        mistakes: Are noted by `open_server`.

    Attributes:
        audience: Who looks.
        mistakes: Logs what browsers send that makes no sense.
    """

    def __init__(self, host: str, port: int, audience: ClientTracker, mistakes: LogOnce) -> None:
        super().__init__(host, port, verbose=False)
        self.audience = audience
        self.mistakes = mistakes
        audience.follow(self)

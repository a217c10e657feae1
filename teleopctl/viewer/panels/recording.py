"""Recording of a bag of all topics, begun and ended on the page."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.viewer.panels.base import Page

# Time for a recorder to write the end of its file.
_TIMEOUT_S = 30.0


class PageRecording:
    """A recorder of all topics, which runs as a process of its own: ``teleopctl bag record``.

    Args:
        page: The viewer's node.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._recorder: subprocess.Popen[bytes] | None = None
        self._folder = Path()
        self._started_s = 0.0

    @property
    def duration_s(self) -> float | None:
        """Time since the start in seconds; None while nothing is recorded."""
        return None if self._recorder is None else time.monotonic() - self._started_s

    def check(self) -> None:
        """Report a recorder that has ended by itself."""
        if self._recorder is not None and self._recorder.poll() is not None:
            self._recorder = None
            self._page.notify("The recording has ended", f"See {self._folder}", wrong=True)

    def start(self) -> None:
        """Record all topics, into a folder named after the time."""
        self._folder = Path(time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S")).absolute()
        command = [sys.executable, "-m", "teleopctl", "bag", "record", "--all"]
        self._recorder = subprocess.Popen(
            [*command, "--output", str(self._folder)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "ROS_DOMAIN_ID": str(self._page.node.context.get_domain_id())},
        )
        self._started_s = time.monotonic()
        self._page.notify("Recording all topics", str(self._folder))

    def stop(self) -> None:
        """End the recording, if there is one."""
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        recorder.send_signal(signal.SIGINT)

        def wait() -> None:
            recorder.wait(_TIMEOUT_S)

        self._page.stage.run_in_background(
            wait, lambda _result: self._page.notify("Recorded", str(self._folder))
        )

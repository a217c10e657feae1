"""Growth of a data set: saved episodes are added by a process beside the recorder."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from teleopctl.bag import EpisodeFolder
from teleopctl.node import Node


class DataSetGrowth:
    """Processes that add saved episodes to the data set, one after the other.

    Args:
        node: Node of the recorder, for its log.
        on_grown: Called after the data set has grown, on a thread.

    Attributes:
        count: Number of episodes in the data set.
        problem: Why the newest episodes are not in the data set; empty if they are.
    """

    def __init__(self, node: Node, on_grown: Callable[[], object]) -> None:
        self._node = node
        self._on_grown = on_grown
        self._wanted = threading.Event()
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()
        self.count = 0
        self.problem = ""

    def begin(self, folder: EpisodeFolder) -> None:
        """Add all saved episodes on a thread; ones saved meanwhile as well."""
        self._wanted.set()
        with self._lock:
            if self._thread is None or not self._thread.is_alive():
                self._thread = threading.Thread(target=self._run, args=[folder.folder])
                self._thread.start()

    def wait(self) -> None:
        """Wait until all saved episodes are in the data set."""
        thread = self._thread
        if thread is not None and thread.is_alive():
            self._node.get_logger().info("Adding saved episodes to the data set")
            thread.join()

    def _run(self, folder: Path) -> None:
        while True:
            with self._lock:
                if not self._wanted.is_set():
                    self._thread = None
                    return
                self._wanted.clear()
            found = EpisodeFolder(folder)
            if found.missing():
                self._add(folder)
                found = EpisodeFolder(folder)
            self.count = len(found.rows())
            if self._node.context.ok():
                self._on_grown()

    def _add(self, folder: Path) -> None:
        command = [sys.executable, "-P", "-m", "teleopctl", "episode", "build", str(folder)]
        # In a session of its own: Ctrl-C in the terminal is for the recorder, which waits for it.
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            start_new_session=os.name != "nt",
        )
        logger = self._node.get_logger()
        for line in done.stdout.splitlines():
            logger.info(line)
        lines = [line.removeprefix("WARNING: ") for line in done.stderr.splitlines()]
        for line in lines:
            (logger.error if done.returncode else logger.warning)(line)
        self.problem = " ".join(lines) if done.returncode else ""

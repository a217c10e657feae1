"""Keeps the status file of a launch true, also when the disk is full for a while."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from teleopctl.launch.execution import status
from teleopctl.launch.execution.event_loop import EventLoop
from teleopctl.launch.execution.status import ProcessStatus

# When to write the file again that could not be written.
_TRY_AGAIN_AFTER_S = 1.0


class Launched(Protocol):
    """Interface of a running launch, for its status file."""

    def statuses(self) -> list[ProcessStatus]:
        """Return the state of each process."""

    def pending(self) -> int:
        """Return the number of timers that are due soon."""


class PublishedStatus:
    """Writes the status file of one launch.

    Args:
        folder: The launch's log folder.
        loop: The loop on which `publish` is called.
        launch: Is asked for what to write.
    """

    def __init__(self, folder: Path, loop: EventLoop, launch: Launched) -> None:
        self._folder = folder
        self._loop = loop
        self._launch = launch
        self._is_late = False

    def publish(self) -> None:
        """Write the status file, now or soon."""
        try:
            status.write(self._folder, self._launch.statuses(), self._launch.pending())
        except OSError:
            # A full disk, or on Windows a reader: no reason to end what runs.
            if not self._is_late:
                self._is_late = True
                self._loop.after(_TRY_AGAIN_AFTER_S, self._publish_late)

    def _publish_late(self) -> None:
        self._is_late = False
        self.publish()

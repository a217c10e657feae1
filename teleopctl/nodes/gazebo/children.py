"""Processes that come and go with the one that started them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType

from teleopctl.base import background, progress
from teleopctl.nodes.gazebo.simulation import Program

# Ctrl-C, and a launch that ends, reach the whole process group: at first they end by themselves.
_GRACE_S = 2.0


class Children:
    """Child processes of this one, ended at the end of the ``with`` block."""

    def __init__(self) -> None:
        self._folder = background.temporary_folder()
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._may_end: set[str] = set()

    def __enter__(self) -> Children:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        interrupted = kind is not None and issubclass(kind, KeyboardInterrupt)
        self._end(at_once=not interrupted)
        self._folder.remove()

    @property
    def folder(self) -> Path:
        """Temporary folder of the child processes."""
        return self._folder.path

    def start(self, programs: Iterable[Program]) -> None:
        """Start programs, whose progress is then available from `said`."""
        for program in programs:
            if program.ends:
                self._may_end.add(program.name)
            said = progress.file_of(self._log(program.name))
            self._processes[program.name] = subprocess.Popen(
                program.command,
                env={**os.environ, progress.VARIABLE: str(said)},
                stdin=subprocess.DEVNULL,
                restore_signals=False,
            )

    def said(self, name: str) -> progress.Progress | None:
        """Return the last reported progress of a program."""
        return progress.read(self._log(name))

    def end(self) -> None:
        """End all child processes, the simulator last."""
        self._end(at_once=True)
        for name in self._processes:
            progress.file_of(self._log(name)).unlink(missing_ok=True)
        self._processes.clear()

    def ended(self) -> tuple[str, int] | None:
        """Return name and exit status of a program that ended unexpectedly; None if none did."""
        for name, process in self._processes.items():
            status = process.poll()
            if status is not None and not (status == 0 and name in self._may_end):
                return name, status if status >= 0 else 128 - status
        return None

    def _log(self, name: str) -> Path:
        return self.folder / f"{name}.log"

    def _end(self, *, at_once: bool) -> None:
        # The simulator last: a controller manager tells its hardware good-bye.
        steps = [signal.SIGTERM] if sys.platform == "win32" else [signal.SIGINT, signal.SIGTERM]
        if not at_once:
            self._wait()
        for number in steps:
            for process in reversed(self._processes.values()):
                if process.poll() is None:
                    process.send_signal(number)
            self._wait()
        for process in self._processes.values():
            process.kill()
            process.wait()

    def _wait(self) -> None:
        deadline = time.monotonic() + _GRACE_S
        for process in self._processes.values():
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                return

"""A command in a terminal of its own, for what draws on one; for POSIX."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import select
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from teleopctl.testing import LONGEST_WAIT_S


class Terminal:
    """A program in a terminal.

    Args:
        argv: Program and arguments.
        env: Its whole environment.
        cwd: Where it starts; None for the current folder.

    Attributes:
        text: What it has drawn so far.
    """

    def __init__(
        self, argv: Sequence[str], env: Mapping[str, str], cwd: Path | None = None
    ) -> None:
        self._master, slave = pty.openpty()
        self._process = subprocess.Popen(
            argv,
            env={**env, "TERM": "xterm-256color", "COLUMNS": "90", "LINES": "24"},
            cwd=cwd,
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
        )
        os.close(slave)
        self.text = ""

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def until(self, pattern: str, timeout_s: float = LONGEST_WAIT_S) -> re.Match[str]:
        """Wait until it has drawn something."""
        deadline = time.monotonic() + timeout_s
        while not (match := re.search(pattern, self.text, re.DOTALL)):
            patience = deadline - time.monotonic()
            assert patience > 0 and select.select([self._master], [], [], patience)[0], self.text
            self.text += os.read(self._master, 65536).decode(errors="replace")
        return match

    def report(self) -> str:
        """What it has drawn, and its exit status, for the text of a failure."""
        return f"{self.text}\nstatus: {self._process.returncode}"

    def press(self, keys: str) -> None:
        """Type."""
        os.write(self._master, keys.encode())

    def close(self) -> int:
        """End it, and return its exit status."""
        self._process.terminate()
        return self.wait()

    def kill(self) -> None:
        """End it and what it has started, at once."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self.wait()

    def wait(self) -> int:
        """Wait for its end, and return its exit status."""
        with contextlib.suppress(OSError):  # the other end is closed
            while text := os.read(self._master, 65536):
                self.text += text.decode(errors="replace")
        status = self._process.wait(LONGEST_WAIT_S)
        os.close(self._master)
        return status

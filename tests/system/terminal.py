"""Command in a pseudo-terminal, for programs that draw on a terminal; POSIX only."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import re
import select
import signal
import subprocess
import termios
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from teleopctl.testing import LONGEST_WAIT_S


class Terminal:
    """Program in a pseudo-terminal.

    Args:
        argv: Path of the program, and its arguments.
        env: Environment of the program; TERM, COLUMNS and LINES are set in addition.
        cwd: Working directory of the program; None for the current folder.
        is_controlling: Whether it is the program's controlling terminal, as a user's is.

    Attributes:
        text: Output of the program so far, with escape sequences.
    """

    def __init__(
        self,
        argv: Sequence[str],
        env: Mapping[str, str],
        cwd: Path | None = None,
        *,
        is_controlling: bool = False,
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
            preexec_fn=_take_terminal if is_controlling else None,
        )
        os.close(slave)
        self.text = ""

    @property
    def pid(self) -> int:
        """Process ID of the program."""
        return self._process.pid

    def until(self, pattern: str, timeout_s: float = LONGEST_WAIT_S) -> re.Match[str]:
        """Wait until the output matches a pattern, and return the match."""
        deadline = time.monotonic() + timeout_s
        while not (match := re.search(pattern, self.text, re.DOTALL)):
            patience = deadline - time.monotonic()
            assert patience > 0 and select.select([self._master], [], [], patience)[0], self.text
            self.text += os.read(self._master, 65536).decode(errors="replace")
        return match

    def report(self) -> str:
        """Return output and exit status of the program, for a failure report."""
        return f"{self.text}\nstatus: {self._process.returncode}"

    def press(self, keys: str) -> None:
        """Write keys to the terminal."""
        os.write(self._master, keys.encode())

    def close(self) -> int:
        """Send SIGTERM to the program, wait for its end, and return its exit status."""
        self._process.terminate()
        return self.wait()

    def kill(self) -> None:
        """Kill the program and its process group, and wait for the program's end."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self.wait()

    def wait(self) -> int:
        """Wait for the end of the program, and return its exit status."""
        with contextlib.suppress(OSError):  # raised when the program has closed the terminal
            while text := os.read(self._master, 65536):
                self.text += text.decode(errors="replace")
        status = self._process.wait(LONGEST_WAIT_S)
        os.close(self._master)
        return status


def _take_terminal() -> None:
    """Make standard input the controlling terminal of this process."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)

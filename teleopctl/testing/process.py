"""Process under test: waits for output lines, and reports its output on failure."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

import psutil

LONGEST_WAIT_S = 40.0
"""Default timeout of every wait in seconds; long, since it is reached only on failure."""

# Shortest and longest pause of `eventually` between two checks, in seconds. After a slow check,
# such as running a command, the pause is longer, so that checks do not take most of the CPU.
_LOOK_EVERY_S = 0.01
_LOOK_EVERY_AT_MOST_S = 0.25

# Time in seconds to read the last output of an ended program: reading finishes at once, unless a
# descendant keeps the streams open.
_LAST_LINES_S = 1.0

Stream = Literal["any", "stdout", "stderr"]


class Process:
    """Program under test, run as a child process, whose output lines can be waited for.

    Args:
        argv: Path of the program, and its arguments.
        env: Whole environment of the program.
        cwd: Working directory of the program.
    """

    def __init__(self, argv: Sequence[str], env: Mapping[str, str], cwd: Path) -> None:
        self._argv = list(argv)
        self._lines: list[tuple[str, str]] = []
        self._searched = 0
        self._open_streams = 2
        self._changed = threading.Condition()
        self._popen = subprocess.Popen(
            self._argv,
            env=env,
            cwd=cwd,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            start_new_session=os.name != "nt",
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        self._readers = [
            threading.Thread(target=self._read, args=(name,), daemon=True)
            for name in ("stdout", "stderr")
        ]
        for reader in self._readers:
            reader.start()

    def _read(self, name: str) -> None:
        with getattr(self._popen, name) as stream:
            for line in stream:
                with self._changed:
                    self._lines.append((name, line.rstrip("\n")))
                    self._changed.notify_all()
        with self._changed:
            self._open_streams -= 1
            self._changed.notify_all()

    @property
    def pid(self) -> int:
        """Process ID of the program."""
        return self._popen.pid

    @property
    def returncode(self) -> int | None:
        """Exit status of the program, negative for a signal; None while the program runs."""
        return self._popen.poll()

    @property
    def stdout(self) -> str:
        """Standard output of the program so far, as text."""
        return self._text("stdout")

    @property
    def stderr(self) -> str:
        """Standard error of the program so far, as text."""
        return self._text("stderr")

    def _text(self, stream: str) -> str:
        with self._changed:
            return "".join(f"{line}\n" for name, line in self._lines if name == stream)

    def wait_for_line(
        self, pattern: str, timeout_s: float = LONGEST_WAIT_S, *, stream: Stream = "any"
    ) -> re.Match[str]:
        """Wait for the next output line that matches a pattern, and return the match.

        Args:
            pattern: Regular expression, searched in each line.
            timeout_s: Longest wait in seconds.
            stream: Stream to search: ``stdout``, ``stderr``, or ``any`` for both.

        Raises:
            AssertionError: The timeout has passed, or the program ended without a matching line;
                the message has its whole output.
        """
        regex = re.compile(pattern)
        found: list[re.Match[str]] = []

        def search() -> bool:
            while self._searched < len(self._lines):
                name, line = self._lines[self._searched]
                self._searched += 1
                match = regex.search(line) if stream in ("any", name) else None
                if match:
                    found.append(match)
                    return True
            return self._open_streams == 0

        with self._changed:
            self._changed.wait_for(search, timeout_s)
        if not found:
            if self._open_streams == 0:
                # The program ends shortly after its output; the report needs its exit status.
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self._popen.wait(_LAST_LINES_S)
            raise AssertionError(f"no line matches {pattern!r}\n{self.report()}")
        return found[0]

    def send(self, text: str) -> None:
        """Write text to the program's standard input."""
        assert self._popen.stdin is not None
        self._popen.stdin.write(text)
        self._popen.stdin.flush()

    def interrupt(self) -> None:
        """Send SIGINT to the program, as Ctrl-C does."""
        if sys.platform == "win32":
            # Windows cannot send Ctrl-C to a single process.
            self._popen.send_signal(signal.CTRL_BREAK_EVENT)
        else:
            self._popen.send_signal(signal.SIGINT)

    def terminate(self) -> None:
        """Send SIGTERM to the program."""
        self._popen.terminate()

    def wait(self, timeout_s: float = LONGEST_WAIT_S) -> int:
        """Wait for the end of the program and return its exit status; AssertionError on timeout.

        Raises:
            AssertionError: The timeout has passed; the message has the whole output.
        """
        try:
            status = self._popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"it did not end within {timeout_s} s\n{self.report()}") from None
        with self._changed:
            # A descendant that is still running may keep the streams open.
            self._changed.wait_for(lambda: self._open_streams == 0, _LAST_LINES_S)
        self._close_input()
        return status

    def kill(self) -> None:
        """Kill the program and its descendants (SIGKILL), and wait for the end of the program."""
        with contextlib.suppress(psutil.NoSuchProcess):
            process = psutil.Process(self._popen.pid)
            for descendant in process.children(recursive=True):
                with contextlib.suppress(psutil.NoSuchProcess):
                    descendant.kill()
        self._popen.kill()
        self._popen.wait()
        for reader in self._readers:
            reader.join(_LAST_LINES_S)
        self._close_input()

    def _close_input(self) -> None:
        if self._popen.stdin is not None:
            with contextlib.suppress(OSError):
                self._popen.stdin.close()

    def report(self) -> str:
        """Return the program's command line, output and exit status, for a failure report."""
        with self._changed:
            output = "\n".join(f"{name}: {line}" for name, line in self._lines)
        return f"{shlex.join(self._argv)}\n{output}\nstatus: {self.returncode}"


def eventually(
    check: Callable[[], object], timeout_s: float = LONGEST_WAIT_S, what: str = "it"
) -> None:
    """Call ``check`` until it returns a true value; on timeout raise AssertionError about ``what``.

    Args:
        check: Function called again and again, until it returns a true value.
        timeout_s: Longest wait in seconds.
        what: Subject of the error message, "WHAT did not happen within …".

    Raises:
        AssertionError: ``check`` returned no true value before the timeout.
    """
    begin = now = time.monotonic()
    while not check():
        took_s, now = time.monotonic() - now, time.monotonic()
        if now >= begin + timeout_s:
            raise AssertionError(f"{what} did not happen within {timeout_s:g} s")
        pause_s = min(max(_LOOK_EVERY_S, 2 * took_s), _LOOK_EVERY_AT_MOST_S)
        time.sleep(pause_s)
        now = time.monotonic()

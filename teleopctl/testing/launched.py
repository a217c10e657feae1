"""Running launch file in an isolated graph."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

from teleopctl.base import background
from teleopctl.base.background import ProcessRecord
from teleopctl.launch import stop_running
from teleopctl.testing.process import LONGEST_WAIT_S, eventually


class LaunchedSystem:
    """Launch file running in a test's graph, as `RosGraph.launch` returns it.

    Args:
        record: Record of the launch's background process.

    Attributes:
        name: Name of the launch for ``teleopctl ps``, ``logs`` and ``stop``.
        log_file: File with the output of the processes; each line begins with the process's name.
    """

    def __init__(self, record: ProcessRecord) -> None:
        self.name = record.name
        self.log_file: Path = record.log_file
        self._record = record
        self._searched = 0

    @property
    def output(self) -> str:
        """Output of the launched processes so far, read from the log file at each access."""
        return self.log_file.read_text(encoding="utf-8", errors="replace")

    @property
    def is_running(self) -> bool:
        """Whether the launch's background process is running."""
        return background.is_alive(self._record)

    def wait_for_line(self, pattern: str, timeout_s: float = LONGEST_WAIT_S) -> re.Match[str]:
        """Wait for the next output line that matches a pattern, and return the match.

        Raises:
            AssertionError: The timeout has passed, or the launch ended without a matching line;
                the message has the whole output.
        """
        regex = re.compile(pattern)
        found: list[re.Match[str]] = []

        def search() -> bool:
            # Checked before reading, so that lines written before the end are still read.
            ended = not self.is_running
            for line in self.output.splitlines(keepends=True)[self._searched :]:
                if not line.endswith("\n") and not ended:
                    break
                self._searched += 1
                match = regex.search(line.rstrip("\n"))
                if match:
                    found.append(match)
                    return True
            return ended

        with contextlib.suppress(AssertionError):
            eventually(search, timeout_s)
        if not found:
            raise AssertionError(f"no line matches {pattern!r}\n{self.output}")
        return found[0]

    def stop(self) -> None:
        """Stop the launch with all its processes, as ``teleopctl stop`` does."""
        stop_running(self._record)

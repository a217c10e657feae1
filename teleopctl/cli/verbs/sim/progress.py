"""How far a sweep has come, on stderr: a bar on a terminal, a line for each run elsewhere."""

import sys
import time
from typing import TYPE_CHECKING, Self

from teleopctl.cli import console

if TYPE_CHECKING:
    from teleopctl.sweep import RunResult

_WIDTH = 30
_CLEAR_LINE = "\r\x1b[2K"


class SweepProgress:
    """Prints the start and end of each run of a sweep.

    Args:
        count: How many there are.
        done: How many of them were done before.
        on_terminal: Whether stderr is one.
    """

    def __init__(self, count: int, done: int, *, on_terminal: bool) -> None:
        self._count = count
        self._done = done
        self._before = done
        self._failed = 0
        self._at_work = 0
        self._on_terminal = on_terminal
        self._started = time.monotonic()

    def __enter__(self) -> Self:
        self._draw()
        return self

    def __exit__(self, *_: object) -> None:
        if self._on_terminal:
            sys.stderr.write(_CLEAR_LINE)
            sys.stderr.flush()

    def begin(self) -> None:
        """Report the start of a run."""
        self._at_work += 1
        self._draw()

    def tell(self, result: "RunResult") -> None:
        """Report the end of a run."""
        self._at_work -= 1
        self._done += 1
        self._failed += not result.is_done
        if not self._on_terminal:
            parameters = "".join(f" {name}={value}" for name, value in result.parameters.items())
            console.note(
                f"[{self._done}/{self._count}] run {result.number}{parameters}: {result.result} "
                f"after {result.wall_s:.1f} s"
            )
        self._draw()

    def _draw(self) -> None:
        if not self._on_terminal:
            return
        filled = _WIDTH * self._done // self._count
        text = f"[{'=' * filled}{' ' * (_WIDTH - filled)}] {self._done}/{self._count}"
        text += f", {self._at_work} at work"
        if self._failed:
            text += f", {self._failed} failed"
        if finished := self._done - self._before:
            spent_s = time.monotonic() - self._started
            left_s = round(spent_s / finished * (self._count - self._done))
            text += f", {left_s // 60}:{left_s % 60:02d} left"
        sys.stderr.write(_CLEAR_LINE + text)
        sys.stderr.flush()

"""Lines of a teleoperation device in a terminal, which are written over again and again."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Sequence

# Lines of the text of one part, which is cut behind them.
_MOST_LINES = 2


class StatusLines:
    """Parts of a status below each other, each in whole words of at most two lines.

    The cursor stands at the end of the last line, so that other output begins below it.
    """

    def __init__(self) -> None:
        self._shown: tuple[str, ...] = ()

    def show(self, parts: Sequence[str]) -> None:
        """Write parts in place of those that were written before; empty ones take no line."""
        width = max(shutil.get_terminal_size().columns - 1, 20)
        lines = tuple(
            line
            for part in parts
            if part
            for line in textwrap.wrap(part, width, max_lines=_MOST_LINES, placeholder=" …")
        )
        if lines == self._shown:
            return
        up = len(self._shown) - 1
        self._shown = lines
        begin = "\r" + (f"\x1b[{up}A" if up > 0 else "")
        sys.stdout.write(begin + "\x1b[J" + "\r\n".join(lines))
        sys.stdout.flush()

    def end(self) -> None:
        """Leave the lines as they are: what follows is written below them."""
        if self._shown:
            self._shown = ()
            sys.stdout.write("\r\n")
            sys.stdout.flush()


def who_drives(claim: str) -> str:
    """Return the line of who drives the robot.

    Args:
        claim: The node and its device; empty if none has the command lease.
    """
    return f"driven by {claim}" if claim else "no node drives"

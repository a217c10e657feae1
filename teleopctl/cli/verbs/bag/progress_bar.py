"""Where a player is in its bag, drawn below its other output."""

from __future__ import annotations

import sys

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.interfaces import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from teleopctl.bag import Player

_CLEAR_LINE = "\x1b[2K"
_LINES = 2
_WIDTH = 30


class ProgressBar:
    """Progress bar of ``bag play``, as rosbag2 draws it.

    Args:
        hertz: How often it is to be drawn in a second; 0 for never, negative for each message.
        separation_lines: Empty lines above it, which other output may use.
    """

    def __init__(self, hertz: int, separation_lines: int) -> None:
        self._hertz = hertz
        self._lines = separation_lines
        self._is_left = False

    def explain(self) -> None:
        """Print the meaning of the bar's letters."""
        if not self._hertz:
            return
        how = f"at {self._hertz} Hz" if self._hertz > 0 else "for every message"
        _write(
            f"Progress bar enabled {how}.\n"
            "Progress bar [?]: [R]unning, [P]aused, [B]urst, [D]elayed, [S]topped\n"
        )

    def draw(self, player: Player) -> None:
        """Redraw the bar."""
        if self._hertz and not self._is_left:
            _write(
                f"{_CLEAR_LINE}\n" * self._lines
                + f"{_CLEAR_LINE}====== Playback Progress ======\n"
                + f"{_CLEAR_LINE}{_progress(player)}\n"
                + f"\x1b[{self._lines + _LINES}A"
            )

    def leave(self) -> None:
        """Move the cursor below the bar."""
        if self._hertz and not self._is_left:
            self._is_left = True
            _write(f"\x1b[{self._lines + _LINES}B")


def _progress(player: Player) -> str:
    behind_ns = player.position_ns - player.start_ns
    whole_ns = max(player.end_ns - player.start_ns, 0)
    filled = round(_WIDTH * min(max(behind_ns / whole_ns, 0), 1)) if whole_ns else _WIDTH
    seconds, rest_ns = divmod(player.position_ns, NANOSECONDS_PER_SECOND)
    return (
        f"[{seconds}.{rest_ns:09}] Duration {behind_ns / NANOSECONDS_PER_SECOND:.2f}"
        f"/{whole_ns / NANOSECONDS_PER_SECOND:.2f} [{_status(player)}] "
        f"[{'=' * filled}{' ' * (_WIDTH - filled)}] x{player.rate:g}"
    )


def _status(player: Player) -> str:
    if not player.is_playing:
        return "S"
    if player.is_delayed:
        return "D"
    if player.is_bursting:
        return "B"
    return "P" if player.is_paused else "R"


def _write(text: str) -> None:
    sys.stdout.write(text)
    sys.stdout.flush()

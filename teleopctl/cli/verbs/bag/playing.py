"""A bag player in this process, controlled by keys, with its progress on the terminal."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from teleopctl.bag import Player, PlayOptions
from teleopctl.base.keyboard import DOWN, RIGHT, SPACE, UP, Keyboard
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.interfaces import NANOSECONDS_PER_SECOND
from teleopctl.node import Context, MultiThreadedExecutor, Node, spin_in_thread
from teleopctl.wire import ensure_router

if TYPE_CHECKING:
    from teleopctl.bag import BagMessage, Player


_NODE = "rosbag2_player"
_RATE_STEP = 0.1

# The reader decodes chunks in Python while messages are due, which would be late by up to the
# default interval of 5 ms.
_SWITCH_INTERVAL_S = 0.0002

# Longest wait for the last responses, in seconds; they take this long only on a busy machine.
_LAST_ANSWERS_S = 2.0


@dataclass(frozen=True)
class Terminal:
    """Settings of a bag player's terminal: keyboard control, progress bar and log level.

    Attributes:
        keys: Whether keys control the player.
        progress_hz: Rate at which the progress bar is drawn, in Hz; 0 for never, negative for each
            message.
        progress_lines: Number of empty lines between the progress bar and other output.
        log_level: Lowest log level that is shown.
    """

    keys: bool = True
    progress_hz: int = 0
    progress_lines: int = 2
    log_level: str = "info"


def play_bags(
    bags: Sequence[tuple[Path, str | None]],
    options: PlayOptions,
    remaps: Sequence[str],
    terminal: Terminal,
    burst: int | None = None,
) -> int:
    """Play bags, or a burst of messages, until their end or Ctrl-C; return exit status 0.

    Args:
        bags: Paths of the bags, each with its storage format or None.
        options: Options of the player.
        remaps: Remapping rules ``FROM:=TO``.
        terminal: Keyboard control and progress bar.
        burst: Number of messages to send at once before pausing, 0 for all; None for playback in
            time.

    Raises:
        TeleopctlError: A bag cannot be read.
    """
    sys.setswitchinterval(_SWITCH_INTERVAL_S)
    ensure_router()
    arguments = ["--ros-args", "--log-level", terminal.log_level]
    arguments += [word for rule in remaps for word in ("--remap", rule)]
    context = Context()
    context.init(arguments, publishes_after_signal=True)
    try:
        with Node(_NODE, context=context) as node:
            _play(node, bags, options, terminal, burst)
    except KeyboardInterrupt:
        pass  # a normal end, as in `ros2 bag play`
    finally:
        context.try_shutdown()
    return 0


def _play(
    node: Node,
    bags: Sequence[tuple[Path, str | None]],
    options: PlayOptions,
    terminal: Terminal,
    burst: int | None,
) -> None:
    hertz = terminal.progress_hz if sys.stdout.isatty() else 0
    bar = ProgressBar(hertz, terminal.progress_lines)

    def show(_: BagMessage) -> None:
        if hertz < 0:
            bar.draw(player)

    with Player(node, bags, options, on_published=show) as player:
        bar.print_legend()
        with Keyboard(lambda key: _press(player, key), wanted=terminal.keys):
            if terminal.keys:
                _explain_keys(node)
            player.play()
            # Service requests that arrived before are handled from now on.
            with _served(node):
                try:
                    if burst is not None:
                        player.burst(burst)
                    while not player.wait(1 / hertz if hertz > 0 else None):
                        bar.draw(player)
                finally:
                    # A key's function or a service callback may wait for the player.
                    player.stop()
                    bar.draw(player)
                    bar.finish()


def _press(player: Player, key: str) -> None:
    if key == SPACE:
        player.toggle_paused()
    elif key == RIGHT:
        player.play_next()
    elif key in (UP, DOWN):
        # Rounded, so that ten steps of 0.1 make exactly 1.
        step = _RATE_STEP if key == UP else -_RATE_STEP
        player.set_rate(round(player.rate + step, 6))


def _explain_keys(node: Node) -> None:
    log = node.get_logger()
    log.info("Adding keyboard callbacks.")
    log.info("Press SPACE for Pause/Resume")
    log.info("Press CURSOR_RIGHT for Play Next Message")
    log.info("Press CURSOR_UP for Increase Rate 10%")
    log.info("Press CURSOR_DOWN for Decrease Rate 10%")


@contextlib.contextmanager
def _served(node: Node) -> Iterator[None]:
    """Spin the node on a thread for the time of the block, to serve its services."""
    # One thread for a long burst, and one for other requests at the same time.
    executor = MultiThreadedExecutor(2, context=node.context)
    executor.add_node(node)
    thread = spin_in_thread(executor, "bag-services")
    try:
        yield
    finally:
        # A client that stopped the player by its service still receives the response.
        executor.shutdown(_LAST_ANSWERS_S)
        thread.join()


_CLEAR_LINE = "\x1b[2K"
_LINES = 2
_WIDTH = 30


class ProgressBar:
    """Progress bar of ``bag play``, as rosbag2 draws it.

    Args:
        hertz: Rate at which the bar is drawn, in Hz; 0 for never, negative for each message.
        separation_lines: Number of empty lines above the bar, for other output.
    """

    def __init__(self, hertz: int, separation_lines: int) -> None:
        self._hertz = hertz
        self._lines = separation_lines
        self._is_finished = False

    def print_legend(self) -> None:
        """Print the meaning of the progress bar's letters, if the bar is enabled."""
        if not self._hertz:
            return
        how = f"at {self._hertz} Hz" if self._hertz > 0 else "for every message"
        _write(
            f"Progress bar enabled {how}.\n"
            "Progress bar [?]: [R]unning, [P]aused, [B]urst, [D]elayed, [S]topped\n"
        )

    def draw(self, player: Player) -> None:
        """Redraw the progress bar with the player's position and status."""
        if self._hertz and not self._is_finished:
            _write(
                f"{_CLEAR_LINE}\n" * self._lines
                + f"{_CLEAR_LINE}====== Playback Progress ======\n"
                + f"{_CLEAR_LINE}{_progress(player)}\n"
                + f"\x1b[{self._lines + _LINES}A"
            )

    def finish(self) -> None:
        """Move the cursor below the progress bar; later calls of `draw` have no effect."""
        if self._hertz and not self._is_finished:
            self._is_finished = True
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

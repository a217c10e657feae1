"""``topic echo --plot``: fields of a topic, drawn again and again."""

from __future__ import annotations

import contextlib
import shutil
import sys
import time
from collections.abc import Callable, Iterator

from teleopctl.base.extras import extra
from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verbs.topic.plot import Traces
from teleopctl.errors import TeleopctlError, UnavailableError, UsageError

if TYPE_CHECKING:
    from teleopctl.cli.verbs.topic.source import TopicSource
    from teleopctl.node import QoSProfile

_DRAW_EVERY_S = 0.2
_WIDTH, _HEIGHT = 80, 24


def live_plot(
    source: TopicSource, fields: str, window_s: float, qos: QoSProfile, timeout_s: float | None
) -> None:
    """Plot fields until Ctrl-C or the timeout; without a terminal, print one plot at the end.

    Args:
        source: The topic.
        fields: Paths of fields, with commas between them.
        window_s: How far back is drawn, in seconds.
        qos: Of the subscription.
        timeout_s: Longest time in seconds; None goes on for ever.

    Raises:
        TeleopctlError: A field is wrong, or nothing came.
    """
    with extra("tui", "uniplot"):
        import uniplot as uniplot
    if not 0.0 < window_s < float("inf"):
        raise UsageError(f"The window must be positive, got {window_s:g}")
    paths = [path.strip() for path in fields.split(",")]
    traces = Traces(paths, window_s)
    failures: list[TeleopctlError] = []

    def receive(message: Any) -> None:
        try:
            traces.add(time.monotonic(), message)
        except TeleopctlError as error:
            failures.append(error)

    started_s = time.monotonic()
    ends_s = float("inf") if timeout_s is None else started_s + timeout_s
    with command_node() as node, _canvas(traces) as draw:
        node.create_subscription(source.message_class, source.topic, receive, qos, immediate=True)
        try:
            while node.context.ok() and not failures and (now_s := time.monotonic()) < ends_s:
                time.sleep(min(_DRAW_EVERY_S, ends_s - now_s))
                draw(is_last=False)
        finally:  # after Ctrl-C as well
            if not failures and traces.count:
                draw(is_last=True)
    if failures:
        raise failures[0]
    if not traces.count:
        waited_s = time.monotonic() - started_s
        raise UnavailableError(f"No message on '{source.topic}' within {waited_s:.1f} s")


@contextlib.contextmanager
def _canvas(traces: Traces) -> Iterator[Callable[..., None]]:
    """Return what draws: in place of the drawing before, or the last one only."""
    if not sys.stdout.isatty():

        def draw_last(*, is_last: bool) -> None:
            if is_last:
                text = traces.drawing(time.monotonic(), _WIDTH, _HEIGHT, colour=False)
                console.out_lines(text.splitlines())

        yield draw_last
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    # While it is live, sys.stdout is a stand-in that is no terminal.
    colour = console.colour_enabled(sys.stdout)
    with Live(console=Console(), auto_refresh=False) as live:

        def draw(*, is_last: bool) -> None:
            del is_last
            width, lines = shutil.get_terminal_size()
            text = traces.drawing(time.monotonic(), width, lines - 1, colour=colour)
            live.update(Text.from_ansi(text), refresh=True)

        yield draw

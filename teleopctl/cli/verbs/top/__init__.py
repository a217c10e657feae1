"""``teleopctl top``: processes, topics, controllers and the log on one screen."""

import sys
from typing import Annotated

from teleopctl.base.extras import extra
from teleopctl.cli.graph_lookup import live_graph
from teleopctl.cli.verb import Option, Verb
from teleopctl.errors import UsageError

VERB = Verb(
    f"{__name__}:top",
    "Watch processes, topics, controllers and the log on one screen.",
    examples=("teleopctl top", "teleopctl top --period 0.5"),
)

_SHORTEST_PERIOD_S = 0.1


def top(
    period: Annotated[
        float, Option("--period", help="Seconds between updates.", metavar="SECONDS")
    ] = 1.0,
) -> int:
    """Watch processes, topics, controllers and the log on one screen.

    The last line of the screen lists the keys; no mouse is needed. Topics are measured while they
    are visible; images and point clouds only on request.
    """
    with extra("tui", "textual", "uniplot"):
        import textual as textual
    if not _SHORTEST_PERIOD_S <= period < float("inf"):
        raise UsageError(f"The period is at least {_SHORTEST_PERIOD_S:g} s, got {period:g}")
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise UsageError(
            "`top` draws on a terminal",
            hint="For a file or a pipe there are `ps`, `topic hz --all` and `topic bw --all`.",
        )
    live_graph()  # raises at once if no router runs
    from teleopctl.cli.command_node import command_node
    from teleopctl.cli.verbs.top.app import Top

    with command_node() as node:
        app = Top(node, period)
        app.run()
        return app.return_code or 0

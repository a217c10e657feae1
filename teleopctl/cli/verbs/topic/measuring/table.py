"""Figures of several topics: a table that stands still on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from teleopctl.base.printable import printable_line
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import console

if TYPE_CHECKING:
    from rich.table import Table

Rows = Sequence[tuple[str, ...]]
"""The header and a row for each topic; the topic's name is the first cell."""


@contextmanager
def table_of_topics(topics: Sequence[str], *, as_json: bool) -> Iterator[Callable[[Rows], None]]:
    """Return a function that prints a table of the topics with new values.

    On a terminal it takes the place of the one before, and the others stand in it without figures.

    Args:
        topics: Their names.
        as_json: Nothing is shown here.
    """
    if as_json or len(topics) == 1 or not sys.stdout.isatty():
        yield lambda rows: console.out_lines(_lines(rows))
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(), auto_refresh=False) as live:

        def show(rows: Rows) -> None:
            live.update(_rich_table(rows, topics), refresh=True)

        yield show


def _lines(rows: Rows) -> list[str]:
    """The table as ROS 2 prints it: titles in the middle of their columns, the rest on the left."""
    if len(rows) < 2:
        return []
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    header, *others = rows
    titles = "   ".join(title.center(width) for title, width in zip(header, widths, strict=True))
    lines = [
        "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in others
    ]
    return [titles, "=" * len(titles), *lines, ""]


def _rich_table(rows: Rows, topics: Sequence[str]) -> Table:
    from rich.table import Table
    from rich.text import Text

    header, *others = rows
    by_topic = {row[0]: row for row in others}
    table = Table(box=None, pad_edge=False, header_style="bold")
    for place, title in enumerate(header):
        # Where there is too little room, names are broken and numbers are not.
        table.add_column(title, justify="right" if place else "left", no_wrap=place > 0)
    for topic in topics:
        row = by_topic.get(topic, (topic, *("-" for _ in header[1:])))
        table.add_row(*(Text(printable_line(cell)) for cell in row))
    return table

"""Figures of several topics: a table that stands still on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from teleopctl.cli import console
from teleopctl.cli.live import live_graph
from teleopctl.cli.verbs.topic.source import TopicSource, find_sources
from teleopctl.errors import UsageError
from teleopctl.printable import printable_line

if TYPE_CHECKING:
    from rich.table import Table

Rows = Sequence[tuple[str, ...]]
"""The header and a row for each topic; the topic's name is the first cell."""


def chosen_sources(names: Sequence[str], *, every: bool, raw: bool) -> list[TopicSource]:
    """The topics that a person named, or all.

    Raises:
        UsageError: None was named.
        TeleopctlError: None of them can be measured.
    """
    if every:
        names = [name for name, _ in live_graph().topic_names_and_types()]
    if not names:
        raise UsageError("Name a topic, or measure all of them with --all")
    return find_sources(list(names), raw=raw)


@contextmanager
def table_of_topics(
    sources: Sequence[TopicSource], *, as_json: bool
) -> Iterator[Callable[[Rows], None]]:
    """Return a function that shows a table of the topics that have news.

    On a terminal it takes the place of the one before, and the others stand in it without figures.

    Args:
        sources: The topics.
        as_json: Nothing is shown here.
    """
    if as_json or len(sources) == 1 or not sys.stdout.isatty():
        yield lambda rows: console.out_lines(_lines(rows))
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(), auto_refresh=False) as live:

        def show(rows: Rows) -> None:
            live.update(_rich_table(rows, [source.topic for source in sources]), refresh=True)

        yield show


def _lines(rows: Rows) -> list[str]:
    if len(rows) < 2:
        return []
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = [
        "   ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    ]
    return [lines[0], "=" * len(lines[0]), *lines[1:], ""]


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

"""A table that is refilled each second: the cursor keeps its row, and columns fit the width."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple, TypeVar

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.coordinate import Coordinate
from textual.widgets import DataTable

_Entry = TypeVar("_Entry")
_PADDING = 2
_SCROLLBAR = 2
_LEAST_NAME = 12


class Column(NamedTuple):
    """Title, width and alignment of a table column, after the column of names.

    Attributes:
        title: Title of the column.
        width: Width of the column, in characters.
        least_width: Smallest width of a screen that shows the column, in characters.
        is_number: Whether the column is aligned to the right.
    """

    title: str
    width: int
    least_width: int = 0
    is_number: bool = True


class Row(NamedTuple):
    """Row of a live table: key, name, other cells and Rich style."""

    key: str
    name: str
    cells: Sequence[str]
    style: str = ""


class LiveTable(DataTable[Text]):
    """Table that keeps its rows by key, and gives the name the remaining width.

    Args:
        title: Title of the column of names.
        columns: Other columns.
        id: ID of the widget.
        is_text: Whether the names are texts, which are the last column and are cut at their ends.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("j", "cursor_down", "Down", show=False),
        Binding("k", "cursor_up", "Up", show=False),
    ]

    def __init__(
        self,
        title: str,
        columns: Sequence[Column],
        *,
        id: str,  # noqa: A002
        is_text: bool = False,
    ) -> None:
        super().__init__(cursor_type="row", zebra_stripes=True, id=id)
        self._is_text = is_text
        self._title = title
        self._all_columns = columns
        self._name_width = 0
        self._rows: list[Row] = []
        self._keys: list[str] = []

    @property
    def selected_key(self) -> str | None:
        """Key of the row at the cursor; None for an empty table."""
        return self._keys[self.cursor_row] if 0 <= self.cursor_row < len(self._keys) else None

    def visible_keys(self) -> set[str]:
        """Return the keys of the rows that are scrolled into view."""
        first = max(0, int(self.scroll_y))
        return set(self._keys[first : first + max(1, self.size.height)])

    def fill(self, rows: Sequence[Row]) -> None:
        """Replace the rows of the table, keeping the cursor on its row."""
        self._rows = list(rows)
        shown = self._shown_columns()
        width = self.size.width - _SCROLLBAR - _PADDING
        width -= sum(self._all_columns[index].width + _PADDING for index in shown)
        width = max(_LEAST_NAME, width)
        keys = [row.key for row in rows]
        if (width, len(shown) + 1) != (self._name_width, len(self.columns)):
            self._name_width = width
            self._rebuild(shown)
        elif keys != self._keys:
            self._refill(shown)
        else:
            self._update(shown)

    def on_resize(self) -> None:
        """Fit the columns to the new width; called by Textual when the terminal is resized."""
        self.fill(self._rows)

    def _shown_columns(self) -> list[int]:
        width = self.app.size.width
        return [i for i, column in enumerate(self._all_columns) if width >= column.least_width]

    def _rebuild(self, shown: list[int]) -> None:
        chosen = self.selected_key
        self.clear(columns=True)
        columns = [(Text(self._title), self._name_width)]
        for index in shown:
            column = self._all_columns[index]
            title = Text(column.title, justify="right" if column.is_number else "left")
            columns.append((title, column.width))
        for title, width in self._in_order(columns):
            self.add_column(title, width=width)
        self._add_rows(shown, chosen)

    def _refill(self, shown: list[int]) -> None:
        chosen, scroll = self.selected_key, self.scroll_y
        self.clear()
        self._add_rows(shown, chosen)
        self.scroll_to(y=scroll, animate=False)

    def _add_rows(self, shown: list[int], chosen: str | None) -> None:
        for row in self._rows:
            self.add_row(*self._cells(row, shown), key=row.key)
        self._keys = [row.key for row in self._rows]
        if chosen in self._keys:
            self.move_cursor(row=self._keys.index(chosen), scroll=False)

    def _update(self, shown: list[int]) -> None:
        for line, row in enumerate(self._rows):
            for place, cell in enumerate(self._cells(row, shown)):
                coordinate = Coordinate(line, place)
                if self.get_cell_at(coordinate) != cell:
                    self.update_cell_at(coordinate, cell)

    def _cells(self, row: Row, shown: list[int]) -> list[Text]:
        name = row.name if self._is_text else shortened(row.name, self._name_width)
        cells = [Text(name, style=row.style, overflow="ellipsis", no_wrap=True)]
        for index in shown:
            column = self._all_columns[index]
            text = shortened(row.cells[index], column.width)
            cells.append(
                Text(text, style=row.style, justify="right" if column.is_number else "left")
            )
        return self._in_order(cells)

    def _in_order(self, entries: list[_Entry]) -> list[_Entry]:
        return [*entries[1:], entries[0]] if self._is_text else entries


_UNITS = ("B", "kB", "MB", "GB", "TB")
_THOUSAND = 1000.0


def percent_text(value: float | None) -> str:
    """Return a percentage as text with one decimal and without sign; empty for None."""
    return "" if value is None else f"{value:.1f}"


def size_text(value: float | None, per: str = "") -> str:
    """Return bytes as text in a decimal unit plus a suffix: ``1.2 MB/s``; empty for None."""
    if value is None:
        return ""
    for unit in _UNITS:
        if value < _THOUSAND or unit == _UNITS[-1]:
            break
        value /= _THOUSAND
    digits = 0 if unit == "B" else 1
    return f"{value:.{digits}f} {unit}{per}"


def rate_text(value: float) -> str:
    """Return a rate as text without unit, with one decimal below 100 Hz."""
    return f"{value:.1f}" if value < 100 else f"{value:.0f}"


def age_text(seconds: float | None) -> str:
    """Return a duration as text in ms, s, minutes or hours; empty for None."""
    if seconds is None:
        return ""
    if seconds < 1.0:
        return f"{seconds * 1000:.0f} ms"
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    minutes = int(seconds) // 60
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def execution_time_text(microseconds: float | None) -> str:
    """Return a duration as text in µs or, from 1000 µs on, in ms; empty for None."""
    if microseconds is None:
        return ""
    if microseconds < _THOUSAND:
        return f"{microseconds:.0f} µs"
    return f"{microseconds / _THOUSAND:.1f} ms"


def shortened(name: str, width: int) -> str:
    """Return a name, cut at its beginning with ``…`` if longer than a width in characters."""
    return name if len(name) <= width else f"…{name[len(name) - width + 1 :]}"

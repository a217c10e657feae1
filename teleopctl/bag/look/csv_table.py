"""One topic as CSV."""

from __future__ import annotations

import csv
from pathlib import Path

from teleopctl.bag.look.columns import Columns, Lengths
from teleopctl.bag.look.decoding import Decoded
from teleopctl.interfaces import Message

TIMES = ("log_time_ns", "publish_time_ns")
"""The first columns of a table: nanoseconds since the epoch."""


class CsvTable:
    """CSV file with a row per message of a topic.

    Args:
        path: The file.
        message_class: The type of the messages.
        lengths: How long their sequences are; see `columns`.

    Attributes:
        column_count: How many columns it has.
        row_count: How many rows were written.
    """

    def __init__(self, path: Path, message_class: type[Message], lengths: Lengths) -> None:
        self.path = path
        self.row_count = 0
        self._columns = Columns(message_class, lengths)
        self.column_count = len(TIMES) + len(self._columns.names)
        # The line ends of RFC 4180 are also why a text with a lone CR is quoted.
        self._file = path.open("w", encoding="utf-8", newline="")
        self._writer = csv.writer(self._file)
        self._writer.writerow([*TIMES, *self._columns.names])

    def write(self, decoded: Decoded) -> None:
        """Add a row."""
        cells = self._columns.row(decoded.message)
        self._writer.writerow([decoded.log_time_ns, decoded.publish_time_ns, *cells])
        self.row_count += 1

    def close(self) -> None:
        """Flush and close the file."""
        self._file.close()

"""A bag as tables: a file of CSV or Parquet for each topic."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Literal, NamedTuple

from teleopctl.bag.look.columns import Lengths, measure
from teleopctl.bag.look.csv_table import CsvTable
from teleopctl.bag.look.decoding import PICTURES, Decoder
from teleopctl.bag.look.file_names import file_stems, make_folder, whole_or_gone
from teleopctl.bag.look.parquet_table import ParquetTable
from teleopctl.bag.storage.bag import Bag
from teleopctl.errors import SystemFailureError

# Their numbers say nothing in a table.
_CLOUDS = frozenset({"sensor_msgs/msg/PointCloud2"})
# Open at a time; some systems allow 256 files.
_MOST_FILES = 100


class ExportedFile(NamedTuple):
    """A written table.

    Attributes:
        path: Where it is.
        topic: What it is of.
        rows: How many messages it has.
        columns: How many columns.
        unreadable: How many messages of the topic could not be read.
        reason: Why the first of these could not.
    """

    path: Path
    topic: str
    rows: int
    columns: int
    unreadable: int = 0
    reason: str = ""


class TableExport:
    """Exports each topic of a bag to a table.

    Holds one chunk of the bag and some rows of each table in memory at a time. A bag with
    sequences is read twice for CSV, whose columns have to be known first.

    Args:
        bag: The bag.
        folder: Where the files go; made here.
        topics: The topics; all of the bag if None.
        form: What the files are.

    Attributes:
        left_out: The topics that are not written, with the reason.

    Raises:
        NotFoundError: The bag has no such topic.
        InvalidMessageError: A topic that was named cannot be decoded.
    """

    def __init__(
        self,
        bag: Bag,
        folder: Path,
        topics: Collection[str] | None = None,
        form: Literal["csv", "parquet"] = "csv",
    ) -> None:
        self._decoder = Decoder(bag, topics)
        self._folder = folder
        self._form = form
        self.left_out = dict(self._decoder.left_out)
        for name, topic in self._decoder.topics.items():
            if topic.type_name in PICTURES:
                self.left_out[name] = "Pictures make a film: --format mp4"
            elif topic.type_name in _CLOUDS:
                self.left_out[name] = "Point clouds make no table"
        self._topics = [name for name in self._decoder.topics if name not in self.left_out]

    def files(self) -> Iterator[ExportedFile]:
        """Write the tables, and yield each when it is finished.

        Raises:
            RefusedError: The folder holds something already.
            SystemFailureError: A file cannot be written.
            MissingExtraError: pyarrow is needed and not installed.
            InvalidFileError: A part of the bag is broken.
        """
        make_folder(self._folder)
        stems = file_stems(self._topics)
        for start in range(0, len(self._topics), _MOST_FILES):
            group = self._topics[start : start + _MOST_FILES]
            try:
                yield from self._write({name: stems[name] for name in group})
            except OSError as error:
                raise SystemFailureError(
                    f"Cannot write to {self._folder}: {error.strerror or error}"
                ) from error

    def _write(self, stems: dict[str, str]) -> Iterator[ExportedFile]:
        lengths = self._measured(stems) if self._form == "csv" else {}
        paths = {name: self._folder / f"{stem}.{self._form}" for name, stem in stems.items()}
        with whole_or_gone(paths.values()), ExitStack() as stack:
            tables = {}
            for name, path in paths.items():
                tables[name] = table = self._table(path, name, lengths.get(name, {}))
                stack.callback(table.close)
            for decoded in self._decoder.messages(stems):
                tables[decoded.topic].write(decoded)
        for name, table in tables.items():
            yield ExportedFile(
                table.path,
                name,
                table.row_count,
                table.column_count,
                self._decoder.unreadable.get(name, 0),
                self._decoder.reasons.get(name, ""),
            )

    def _measured(self, topics: Collection[str]) -> dict[str, Lengths]:
        lengths: dict[str, Lengths] = {name: {} for name in topics}
        for decoded in self._decoder.messages(topics):
            measure(decoded.message, lengths[decoded.topic])
        return lengths

    def _table(self, path: Path, topic: str, lengths: Lengths) -> CsvTable | ParquetTable:
        message_class = self._decoder.message_class(topic)
        if self._form == "csv":
            return CsvTable(path, message_class, lengths)
        return ParquetTable(path, message_class, topic)

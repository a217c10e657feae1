"""A bag as tables: a CSV or Parquet file for each topic, with a column for each field.

In CSV a sequence has as many columns as its longest value in the bag. A sequence that would need
too many columns is one column of JSON, or of Base64 for bytes. In Parquet sequences are lists.
"""

from __future__ import annotations

import base64
import csv
import json
import math
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

from teleopctl.bag.base import Bag
from teleopctl.bag.export.decoding import PICTURES, DecodedMessage, Decoder
from teleopctl.bag.export.output_folder import file_stems, make_output_folder, removed_on_error
from teleopctl.base.extras import extra
from teleopctl.errors import SystemFailureError
from teleopctl.interfaces import (
    MOST_ELEMENTS,
    FieldType,
    Message,
    Shape,
    class_within,
    message_to_dict,
)

# Limit for one sequence of messages, each of which may have several columns.
_MOST_COLUMNS = 512
_BYTES = ("uint8", "byte", "char")

Cell: TypeAlias = str | int | float | None
Lengths: TypeAlias = dict[str, int]
"""Longest length of each sequence, by its path without indices (``points[].positions``)."""

# Any: the value of a field.
_Put: TypeAlias = Callable[[Any, list[Cell]], None]


class MessageColumns:
    """Columns of a CSV table for a message type: one for each field and array element.

    Args:
        message_class: Class of the message type.
        lengths: Longest length of each sequence, collected by `update_lengths`.

    Attributes:
        names: Names of the columns, such as ``header.stamp.sec`` and ``position[0]``.
    """

    def __init__(self, message_class: type[Message], lengths: Lengths) -> None:
        self._lengths = lengths
        self.names, self._put = self._message(message_class, "")

    def row(self, message: Message) -> list[Cell]:
        """Return a message's cells in the order of the columns; None for missing array elements."""
        cells: list[Cell] = []
        self._put(message, cells)
        return cells

    def _message(self, message_class: type[Message], path: str) -> tuple[list[str], _Put]:
        names: list[str] = []
        puts: list[tuple[str, _Put]] = []
        for field in message_class.__definition__.fields:
            inner = f"{path}.{field.attribute}" if path else field.attribute
            own_names, put = self._field(message_class, field.type, inner)
            names += [f"{field.attribute}{name}" for name in own_names]
            puts.append((field.attribute, put))

        def put_message(message: Message, cells: list[Cell]) -> None:
            for attribute, put in puts:
                put(getattr(message, attribute), cells)

        return names, put_message

    def _field(self, owner: type[Message], kind: FieldType, path: str) -> tuple[list[str], _Put]:
        """Return the suffixes of a field's column names, and the function that fills its cells."""
        if kind.shape is Shape.SINGLE:
            return self._single(owner, kind, path)
        length = self._lengths.get(path, 0)
        if not length:
            return [], _put_null
        names, put = self._single(owner, kind, f"{path}[]")
        if length > MOST_ELEMENTS or length * len(names) > _MOST_COLUMNS:
            return [""], _put_bytes if kind.base in _BYTES else _put_json

        def put_elements(values: Any, cells: list[Cell]) -> None:
            elements = values if isinstance(values, list) else values.tolist()
            for element in elements:
                put(element, cells)
            cells += [None] * (len(names) * (length - len(elements)))

        return [f"[{index}]{name}" for index in range(length) for name in names], put_elements

    def _single(self, owner: type[Message], kind: FieldType, path: str) -> tuple[list[str], _Put]:
        if not kind.is_nested:
            return [""], _put_number if kind.base == "byte" else _put_value
        names, put = self._message(class_within(owner, kind.base), path)
        return [f".{name}" for name in names], put


def update_lengths(message: Message, lengths: Lengths, path: str = "") -> None:
    """Update `lengths`, the longest length of each sequence field so far, with a message."""
    for field in message.__definition__.fields:
        kind = field.type
        if kind.shape is Shape.SINGLE and not kind.is_nested:
            continue
        inner = f"{path}.{field.attribute}" if path else field.attribute
        value = getattr(message, field.attribute)
        if kind.shape is Shape.SINGLE:
            update_lengths(value, lengths, inner)
            continue
        length = len(value)
        if length > lengths.get(inner, 0):
            lengths[inner] = length
        # A sequence that is too long becomes one column, whatever its elements are.
        if kind.is_nested and lengths.get(inner, 0) <= MOST_ELEMENTS:
            for element in value:
                update_lengths(element, lengths, f"{inner}[]")


def _put_null(_value: object, _cells: list[Cell]) -> None:
    pass


def _put_value(value: Cell, cells: list[Cell]) -> None:
    cells.append(value)


def _put_number(value: bytes, cells: list[Cell]) -> None:
    cells.append(value[0])


def _put_bytes(values: Any, cells: list[Cell]) -> None:
    data = b"".join(values) if isinstance(values, list) else bytes(values)
    cells.append(base64.b64encode(data).decode("ascii"))


def _put_json(values: Any, cells: list[Cell]) -> None:
    elements = values if isinstance(values, list) else values.tolist()
    cells.append(json.dumps(list(map(_json_value, elements)), ensure_ascii=False))


def _json_value(value: Any) -> object:
    """Return a value for JSON as `message_to_dict` does: NaN and infinities become texts."""
    if isinstance(value, Message):
        return message_to_dict(value)
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value


TIMES = ("log_time_ns", "publish_time_ns")
"""Names of the first columns of a table, in nanoseconds since the epoch."""


class CsvTable:
    """Writer of a CSV file with a row for each message of a topic.

    Args:
        path: Path of the file.
        message_class: Class of the messages.
        lengths: Longest length of each sequence, collected by `update_lengths`.

    Attributes:
        column_count: Number of columns.
        row_count: Number of rows written.
    """

    def __init__(self, path: Path, message_class: type[Message], lengths: Lengths) -> None:
        self.path = path
        self.row_count = 0
        self._columns = MessageColumns(message_class, lengths)
        self.column_count = len(TIMES) + len(self._columns.names)
        # newline="" keeps the line ends of RFC 4180, with which a text with a lone CR is quoted.
        self._file = path.open("w", encoding="utf-8", newline="")
        self._writer = csv.writer(self._file)
        self._writer.writerow([*TIMES, *self._columns.names])

    def write(self, decoded: DecodedMessage) -> None:
        """Write a decoded message as a row of the CSV file."""
        cells = self._columns.row(decoded.message)
        self._writer.writerow([decoded.log_time_ns, decoded.publish_time_ns, *cells])
        self.row_count += 1

    def close(self) -> None:
        """Flush and close the CSV file."""
        self._file.close()


# Size of a row group, which the writer holds in memory and a reader loads at once.
_MOST_ROWS = 10_000
_MOST_VALUES = 2_000_000
_NAMES = {
    "bool": "bool_",
    "byte": "uint8",
    "char": "uint8",
    "string": "string",
    "wstring": "string",
}


class ParquetTable:
    """Writer of a Parquet file with a row for each message of a topic.

    Args:
        path: Path of the file.
        message_class: Class of the messages.
        topic: Name of the topic, written to the file's metadata with the type.

    Attributes:
        column_count: Number of columns.
        row_count: Number of rows written.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """

    def __init__(self, path: Path, message_class: type[Message], topic: str) -> None:
        with extra("export", "pyarrow"):
            import pyarrow as pa
            from pyarrow import parquet
        self.path = path
        self.row_count = 0
        self._pa = pa
        columns = [(name, pa.int64()) for name in TIMES]
        self._leaves: list[tuple[str, ...]] = []
        self._add_columns(message_class, (), columns)
        self.column_count = len(columns)
        metadata = {"topic": topic, "type": message_class.TYPE_NAME}
        self._schema = pa.schema(columns, metadata)
        self._values: list[list[Any]] = [[] for _ in columns]
        self._held = 0
        self._writer = parquet.ParquetWriter(path, self._schema, compression="zstd")

    def write(self, decoded: DecodedMessage) -> None:
        """Add a decoded message as a row; write a group of rows to the file when it is full."""
        row = self._values
        row[0].append(decoded.log_time_ns)
        row[1].append(decoded.publish_time_ns)
        for column, steps in zip(row[2:], self._leaves, strict=True):
            value = decoded.message
            for step in steps:
                value = getattr(value, step)
            if hasattr(value, "__len__"):
                self._held += len(value)
            column.append(_plain(value))
        self.row_count += 1
        self._held += len(self._leaves)
        if len(row[0]) >= _MOST_ROWS or self._held >= _MOST_VALUES:
            self._flush()

    def close(self) -> None:
        """Write the last rows and close the Parquet file."""
        self._flush()
        self._writer.close()

    def _flush(self) -> None:
        if self._values[0]:
            arrays = [
                self._pa.array(values, field.type)
                for values, field in zip(self._values, self._schema, strict=True)
            ]
            self._writer.write_batch(self._pa.record_batch(arrays, schema=self._schema))
        for values in self._values:
            values.clear()
        self._held = 0

    # Any: types of pyarrow, which has no type annotations.
    def _add_columns(
        self, message_class: type[Message], above: tuple[str, ...], columns: list[tuple[str, Any]]
    ) -> None:
        for field in message_class.__definition__.fields:
            steps = (*above, field.attribute)
            kind = field.type
            if kind.is_nested and kind.shape is Shape.SINGLE:
                self._add_columns(class_within(message_class, kind.base), steps, columns)
                continue
            columns.append((".".join(steps), self._type(message_class, kind)))
            self._leaves.append(steps)

    def _type(self, owner: type[Message], kind: FieldType) -> Any:
        if kind.shape is not Shape.SINGLE:
            return self._pa.list_(self._type(owner, kind.element))
        if not kind.is_nested:
            return getattr(self._pa, _NAMES.get(kind.base, kind.base))()
        nested = class_within(owner, kind.base)
        return self._pa.struct(
            [
                (field.attribute, self._type(nested, field.type))
                # Parquet has no struct without fields, so wire_fields has one in that case.
                for field in nested.__definition__.wire_fields
            ]
        )


def _plain(value: Any) -> Any:
    """Return a field value in a form that pyarrow accepts."""
    if isinstance(value, Message):
        names = (field.attribute for field in value.__definition__.fields)
        return {name: _plain(getattr(value, name)) for name in names}
    if isinstance(value, bytes):
        return value[0]
    if isinstance(value, list):
        return [_plain(element) for element in value] if value and _is_wrapped(value[0]) else value
    if hasattr(value, "tolist"):
        import numpy as np

        return np.asarray(value)
    return value


def _is_wrapped(value: object) -> bool:
    return isinstance(value, Message | bytes)


# Point clouds are not exported: their bytes are of no use in a table.
_CLOUDS = frozenset({"sensor_msgs/msg/PointCloud2"})
# Number of files open at a time; some systems allow 256.
_MOST_FILES = 100


class ExportedTable(NamedTuple):
    """Result of `TableExport` for one topic: file, row and column counts, unreadable messages.

    Attributes:
        path: Path of the file.
        topic: Name of the topic.
        rows: Number of rows, one for each message.
        columns: Number of columns.
        unreadable: Number of messages of the topic that could not be decoded.
        reason: Error of the first message that could not be decoded.
    """

    path: Path
    topic: str
    rows: int
    columns: int
    unreadable: int = 0
    reason: str = ""


class TableExport:
    """Export of a bag's topics to one CSV or Parquet file each, except images and point clouds.

    The export holds one chunk of the bag and some rows of each table in memory at a time. For CSV,
    the bag is read twice, since the columns depend on the lengths of sequences.

    Args:
        bag: Bag to export.
        folder: Folder of the files, created if missing.
        topics: Names of the topics to export; all of the bag if None.
        form: Format of the files: ``csv`` or ``parquet``.

    Attributes:
        left_out: Reason for each topic that is not exported, by name.

    Raises:
        NotFoundError: The bag does not have one of the topics.
        InvalidMessageError: One of the named topics cannot be decoded.
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
                self.left_out[name] = "Images are exported as a video: --format mp4"
            elif topic.type_name in _CLOUDS:
                self.left_out[name] = "Point clouds cannot be exported as a table"
        self._topics = [name for name in self._decoder.topics if name not in self.left_out]

    def write(self) -> Iterator[ExportedTable]:
        """Write the table files while iterated; yield an `ExportedTable` for each finished file.

        Raises:
            RefusedError: The folder is not empty.
            SystemFailureError: A file cannot be written.
            MissingExtraError: pyarrow, which Parquet needs, is not installed.
            InvalidFileError: A part of the bag is broken.
        """
        make_output_folder(self._folder)
        stems = file_stems(self._topics)
        for start in range(0, len(self._topics), _MOST_FILES):
            group = self._topics[start : start + _MOST_FILES]
            try:
                yield from self._write_group({name: stems[name] for name in group})
            except OSError as error:
                raise SystemFailureError(
                    f"Cannot write to {self._folder}: {error.strerror or error}"
                ) from error

    def _write_group(self, stems: dict[str, str]) -> Iterator[ExportedTable]:
        lengths = self._measured(stems) if self._form == "csv" else {}
        paths = {name: self._folder / f"{stem}.{self._form}" for name, stem in stems.items()}
        with removed_on_error(paths.values()), ExitStack() as stack:
            tables = {}
            for name, path in paths.items():
                tables[name] = table = self._table(path, name, lengths.get(name, {}))
                stack.callback(table.close)
            for decoded in self._decoder.messages(stems):
                tables[decoded.topic].write(decoded)
        for name, table in tables.items():
            yield ExportedTable(
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
            update_lengths(decoded.message, lengths[decoded.topic])
        return lengths

    def _table(self, path: Path, topic: str, lengths: Lengths) -> CsvTable | ParquetTable:
        message_class = self._decoder.message_class(topic)
        if self._form == "csv":
            return CsvTable(path, message_class, lengths)
        return ParquetTable(path, message_class, topic)

"""One topic as Parquet: nested messages in columns with dotted names, sequences as lists."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from teleopctl.bag.look.csv_table import TIMES
from teleopctl.bag.look.decoding import Decoded
from teleopctl.base.extras import extra
from teleopctl.interfaces import FieldType, Message, Shape, class_within

# A group of rows is held in memory, and is what a reader takes at once.
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
    """Parquet file with a row per message of a topic.

    Args:
        path: The file.
        message_class: The type of the messages.
        topic: The name of the topic, which the file's metadata tells with the type.

    Attributes:
        column_count: How many columns it has.
        row_count: How many rows were written.

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

    def write(self, decoded: Decoded) -> None:
        """Add a row."""
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
        """Finish and close the file."""
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

    # Any: types of pyarrow, which has no annotations.
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
                # Parquet has no record without a field either.
                for field in nested.__definition__.wire_fields
            ]
        )


def _plain(value: Any) -> Any:
    """A value as pyarrow takes it."""
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

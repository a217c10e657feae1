"""A message as one row of a table: every field of it in columns with dotted names.

A sequence has as many columns as its longest value in the bag, where that makes few; else it is one
column of JSON, or of Base64 where it is a block of bytes. An array is a sequence whose values all
have the same length.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable
from typing import Any, TypeAlias

from teleopctl.interfaces import (
    MOST_ELEMENTS,
    FieldType,
    Message,
    Shape,
    class_within,
    message_to_dict,
)

# Of one sequence, whose elements are messages.
_MOST_COLUMNS = 512
_BYTES = ("uint8", "byte", "char")

Cell: TypeAlias = str | int | float | None
Lengths: TypeAlias = dict[str, int]
"""Of each sequence, by its path without indices (``points[].positions``), the longest length."""

# Any: the value of a field.
_Put: TypeAlias = Callable[[Any, list[Cell]], None]


class Columns:
    """Table columns of a message type.

    Args:
        message_class: The type.
        lengths: What `measure` found.

    Attributes:
        names: Such as ``header.stamp.sec`` and ``position[0]``.
    """

    def __init__(self, message_class: type[Message], lengths: Lengths) -> None:
        self._lengths = lengths
        self.names, self._put = self._message(message_class, "")

    def row(self, message: Message) -> list[Cell]:
        """Return the cells of a message; None for missing elements."""
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
        """What stands behind the field's name in its columns, and what puts its value there."""
        if kind.shape is Shape.SINGLE:
            return self._single(owner, kind, path)
        length = self._lengths.get(path, 0)
        if not length:
            return [], _put_nothing
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


def measure(message: Message, lengths: Lengths, path: str = "") -> None:
    """Update the largest lengths of a message's sequences."""
    for field in message.__definition__.fields:
        kind = field.type
        if kind.shape is Shape.SINGLE and not kind.is_nested:
            continue
        inner = f"{path}.{field.attribute}" if path else field.attribute
        value = getattr(message, field.attribute)
        if kind.shape is Shape.SINGLE:
            measure(value, lengths, inner)
            continue
        length = len(value)
        if length > lengths.get(inner, 0):
            lengths[inner] = length
        # What is too long will be one column, whatever is inside.
        if kind.is_nested and lengths.get(inner, 0) <= MOST_ELEMENTS:
            for element in value:
                measure(element, lengths, f"{inner}[]")


def _put_nothing(_value: object, _cells: list[Cell]) -> None:
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
    """As `message_to_dict` has it: JSON has no NaN and no infinity, which become texts."""
    if isinstance(value, Message):
        return message_to_dict(value)
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value

"""Messages to YAML, JSON and CSV, in the words of ``ros2 topic echo``."""

from __future__ import annotations

import math

from teleopctl.base.typed import Any, NamedTuple
from teleopctl.interfaces.definition import FLOATS, STRINGS, Field, FieldType, Shape
from teleopctl.interfaces.message import Message, stored
from teleopctl.interfaces.yaml.plain import write_plain

DEFAULT_TRUNCATION = 128
"""Number of array elements, and of string characters, that are shown by default."""

_ELLIPSIS = "..."


class _Options(NamedTuple):
    truncate: int | None
    no_arr: bool
    no_str: bool


def message_to_yaml(
    message: Message,
    *,
    truncate: int | None = DEFAULT_TRUNCATION,
    flow: bool = False,
    no_arr: bool = False,
    no_str: bool = False,
) -> str:
    """Return a message as YAML, as ``ros2 topic echo`` prints it.

    Args:
        message: Message to write.
        truncate: Number of array elements and string characters that are shown; None for all.
        flow: Whether to write arrays on one line.
        no_arr: Whether to write type and length of arrays instead of their elements.
        no_str: Whether to write the length of strings instead of the strings.
    """
    values = _readable(message, _Options(truncate, no_arr, no_str))
    text = write_plain(values, flow=flow)
    if text is not None:
        return text
    from teleopctl.interfaces.yaml.dumping import dump

    return dump(values, flow=flow)


def message_to_dict(message: Message) -> dict[str, Any]:  # Any: values of JSON
    """Return a message as a dictionary of JSON-compatible values.

    JSON has no NaN and no infinity: they become the strings ``NaN``, ``Infinity`` and
    ``-Infinity``, which ``message_from_yaml`` converts back. Bytes become numbers.
    """
    return {field.name: _json_value(message, field) for field in message.__definition__.fields}


# Any: the values of any fields.
def message_values(
    message: Message,
    *,
    truncate: int | None = None,
    no_arr: bool = False,
    no_str: bool = False,
) -> dict[str, Any]:
    """Return the values that `message_to_yaml` writes, as dictionaries and lists."""
    return _readable(message, _Options(truncate, no_arr, no_str))


def message_to_csv(
    message: Message,
    *,
    truncate: int | None = DEFAULT_TRUNCATION,
    no_arr: bool = False,
    no_str: bool = False,
) -> str:
    """Return a message's values on one line, joined by commas; cuts long arrays and strings.

    Args:
        message: Message to write.
        truncate: Number of array elements and string characters that are shown; None for all.
        no_arr: Whether to write type and length of arrays instead of their elements.
        no_str: Whether to write the length of strings instead of the strings.
    """
    return ",".join(_columns(message, _Options(truncate, no_arr, no_str)))


def _readable(message: Message, options: _Options) -> dict[str, Any]:
    return {
        field.attribute: _readable_field(message, field, options)
        for field in message.__definition__.fields
    }


def _readable_field(message: Message, field: Field, options: _Options) -> object:
    value = stored(message, field)
    if field.type.shape is Shape.SINGLE:
        return _readable_value(field.type, value, options)
    if options.no_arr:
        return _abbreviated(field.type, len(value))
    cut = options.truncate is not None and len(value) > options.truncate
    shown = value[: options.truncate] if cut else value
    elements = _elements(shown)
    if not field.type.is_numeric and field.type.base != "bool":
        elements = [_readable_value(field.type, element, options) for element in elements]
    if cut:
        elements.append(_ELLIPSIS)
    return elements


def _readable_value(kind: FieldType, value: Any, options: _Options) -> object:
    if kind.is_nested:
        return _readable(value, options)
    if kind.base == "byte":
        return value.decode("latin-1") if isinstance(value, bytes) else chr(value)
    if kind.base in STRINGS:
        return _shortened(value, options)
    return value


def _shortened(text: str, options: _Options) -> str:
    if options.no_str:
        return f"<string length: <{len(text)}>>"
    if options.truncate is not None and len(text) > options.truncate:
        return text[: options.truncate] + _ELLIPSIS
    return text


def _abbreviated(kind: FieldType, length: int) -> str:
    name = kind.base if kind.is_nested else FieldType(kind.base).idl()
    match kind.shape:
        case Shape.ARRAY:
            return f"<array type: {name}[{kind.capacity}]>"
        case Shape.BOUNDED:
            return f"<sequence type: {name}[{kind.capacity}], length: {length}>"
    return f"<sequence type: {name}, length: {length}>"


def _elements(value: Any) -> list[Any]:
    """Return the elements of a stored sequence of any type as a new list."""
    return list(value) if isinstance(value, list) else list(value.tolist())


def _json_value(message: Message, field: Field) -> object:
    value = stored(message, field)
    if field.type.shape is Shape.SINGLE:
        return _json_single(field.type, value)
    elements = _elements(value)
    if field.type.base in FLOATS and all(map(math.isfinite, elements)):
        return elements
    if field.type.is_numeric and field.type.base not in FLOATS:
        return elements
    return [_json_single(field.type, element) for element in elements]


def _json_single(kind: FieldType, value: Any) -> object:
    if kind.is_nested:
        return message_to_dict(value)
    if kind.base == "byte":
        return value[0]
    if kind.base in FLOATS and not math.isfinite(value):
        if math.isnan(value):
            return "NaN"
        return "Infinity" if value > 0 else "-Infinity"
    return value


def _columns(message: Message, options: _Options) -> list[str]:
    columns: list[str] = []
    for field in message.__definition__.fields:
        value = stored(message, field)
        if field.type.shape is Shape.SINGLE:
            columns.extend(_column(field.type, value, options))
        elif options.no_arr:
            columns.append(_abbreviated(field.type, len(value)))
        elif not len(value):
            columns.append("")
        else:
            shown = value if options.truncate is None else value[: options.truncate]
            for element in _elements(shown):
                columns.extend(_column(field.type, element, options))
            if len(shown) < len(value):
                columns.append(_ELLIPSIS)
    return columns


def _column(kind: FieldType, value: Any, options: _Options) -> list[str]:
    if kind.is_nested:
        return _columns(value, options)
    return [_shortened(value, options) if kind.base in STRINGS else str(value)]

"""Messages from YAML or plain values."""

from __future__ import annotations

import time

from teleopctl.base.typed import Any, Mapping, TypeVar
from teleopctl.errors import UsageError
from teleopctl.interfaces.convert import check_length, converter, expected
from teleopctl.interfaces.definition import (
    FLOATS,
    INTEGER_RANGES,
    STRINGS,
    Field,
    FieldType,
    Shape,
)
from teleopctl.interfaces.message import Message
from teleopctl.interfaces.stamps import Stamp, set_stamp, to_nanoseconds
from teleopctl.interfaces.store import get_message
from teleopctl.interfaces.yaml.plain import read_plain

MessageType = TypeVar("MessageType")

_TIME = "builtin_interfaces/msg/Time"
_HEADER = "std_msgs/msg/Header"
_NOW_WORDS = ("auto", "now")


class _BadValueError(Exception):
    """A value does not fit its field; the error text starts with the path of the field."""


def message_from_yaml(
    message_class: type[MessageType],
    content: str | Mapping[str, object] | None,
    now: int | Stamp | None = None,
) -> MessageType:
    """Return a message whose fields are set from YAML text or plain values.

    Fields that are not mentioned, or null, keep their defaults; as in ROS 2, a null string is the
    text ``None``. A ``std_msgs/msg/Header`` or a
    ``builtin_interfaces/msg/Time`` may be given as ``auto`` or ``now``. As in ROS 2, values are
    converted without loss: a bool may be 1, and the integer 5 may be '5' or 5.0.

    Args:
        message_class: Class of the message.
        content: YAML text, or its values as a mapping; empty for all defaults.
        now: Time for ``auto`` and ``now``: nanoseconds since the epoch, or a
            ``builtin_interfaces/msg/Time``; the present time by default.

    Raises:
        UsageError: The text is not YAML, a field is unknown, or a value does not fit its field; the
            error has the path of the field, the expected type and the value.
    """
    assert issubclass(message_class, Message)
    values: object = _load(content) if isinstance(content, str) else content
    stamp = _nanoseconds(now)
    try:
        message = _message(message_class, values, "", stamp)
    except _BadValueError as error:
        raise UsageError(str(error), hint=_hint(message_class)) from None
    assert isinstance(message, message_class)
    return message


def documents_from_yaml(text: str) -> list[object]:
    """Return the values of the documents in YAML, or of JSON lines; empty ones are left out.

    The output of ``topic echo`` and ``topic echo --json`` can be read. Empty documents are left
    out.

    Raises:
        UsageError: The text is neither YAML nor JSON lines.
    """
    return _json_lines(text) or [each for each in _load_all(text) if each is not None]


def _json_lines(text: str) -> list[object]:
    """Return the values of JSON lines; empty if the text is something else.

    A YAML parser reads most JSON, except numbers such as 1e3 and escaped surrogate pairs.
    """
    lines = [line for line in text.split("\n") if line.strip()]
    if not lines or not all(line.startswith('{"') for line in lines):
        return []
    import json

    try:
        return [json.loads(line) for line in lines]
    except ValueError:
        return []


def _nanoseconds(now: int | Stamp | None) -> int:
    if now is None:
        return time.time_ns()
    return now if isinstance(now, int) else to_nanoseconds(now)


def _load(text: str) -> object:
    documents = [each for each in _load_all(text) if each is not None]
    if len(documents) > 1:
        raise UsageError(f"This is not YAML of one document but of {len(documents)}")
    return documents[0] if documents else None


def _load_all(text: str) -> list[object]:
    if (values := read_plain(text)) is not None:
        return [values]
    import yaml

    from teleopctl.base.ros_yaml import SafeLoader

    try:
        return list(yaml.load_all(text, SafeLoader))
    except UnicodeEncodeError:
        raise  # undecodable bytes in an argument: the command line reports the argument
    except yaml.YAMLError as error:
        raise _not_yaml(text, error) from error


def _not_yaml(text: str, error: Any) -> UsageError:  # Any: an error of PyYAML, imported late
    """Return the error for a text that PyYAML cannot read, with the place and a frequent cause."""
    mark = getattr(error, "problem_mark", None)
    if mark is None:
        return UsageError(f"This is not YAML: {' '.join(str(error).split())}")
    lines = text.splitlines()
    line = lines[mark.line] if mark.line < len(lines) else ""
    hint = None
    if "\t" in line[: mark.column + 1]:
        hint = "YAML allows no tab there: write blanks."
    elif line[mark.column : mark.column + 1] == ":":
        hint = "A blank must follow each colon: {x: 1}."
    place = f"line {mark.line + 1}, column {mark.column + 1}"
    return UsageError(f"This is not YAML: {error.problem} in {place}", hint=hint)


def _hint(message_class: type[Message]) -> str:
    fields = message_class.__definition__.fields
    return f"{message_class.TYPE_NAME} has " + (
        f"the fields {', '.join(f'{field.name} ({field.type})' for field in fields)}."
        if fields
        else "no fields."
    )


def _message(message_class: type[Message], values: object, path: str, now: int) -> Message:
    if isinstance(values, Message) and isinstance(values, message_class):
        return values
    message = message_class()
    if values is None:
        return message
    if isinstance(values, str) and values in _NOW_WORDS and _stamp(message, now):
        return message
    if not isinstance(values, Mapping):
        example = "" if path or ":" not in str(values) else " (a blank must follow each colon)"
        raise _BadValueError(_located(path, f"{expected('a mapping of fields', values)}{example}"))
    known = {name: f for f in message_class.__definition__.fields for name in (f.name, f.attribute)}
    for name, value in values.items():
        field = known.get(str(name))
        if field is None:
            fields = ", ".join(f.name for f in message_class.__definition__.fields) or "none"
            unknown = f"unknown field {str(name)!r} of {message_class.TYPE_NAME} (fields: {fields})"
            raise _BadValueError(_located(path, unknown))
        if value is None:
            if field.type.shape is Shape.SINGLE and field.type.base in STRINGS:
                setattr(message, field.attribute, str(None))  # as in ROS 2
            continue
        where = f"{path}.{name}" if path else str(name)
        setattr(message, field.attribute, _field(field, value, where, now))
    return message


def _stamp(message: Message, now: int) -> bool:
    """Set a Header or a Time to ``now`` and return True; return False for other messages."""
    target: Any = message
    if message.TYPE_NAME == _HEADER:
        target = target.stamp
    elif message.TYPE_NAME != _TIME:
        return False
    set_stamp(target, now)
    return True


def _field(field: Field, value: object, path: str, now: int) -> object:
    if field.type.shape is Shape.SINGLE:
        return _single(field.type, value, path, now)
    if isinstance(value, str | Mapping) or value is None:
        raise _BadValueError(_located(path, expected(field.type, value)))
    if field.type.base not in ("uint8", "byte", "char") or not isinstance(value, bytes):
        if not isinstance(value, list | tuple):
            raise _BadValueError(_located(path, expected(field.type, value)))
        element = field.type.element
        value = [_single(element, v, f"{path}[{i}]", now) for i, v in enumerate(value)]
    try:
        check_length(field.type, len(value))
        return converter(field.type, get_message)(value)
    except (TypeError, ValueError) as error:
        raise _BadValueError(_located(path, str(error))) from None


def _single(kind: FieldType, value: object, path: str, now: int) -> object:
    if kind.is_nested:
        return _message(get_message(kind.base), value, path, now)
    try:
        return converter(kind, get_message)(_as_meant(kind, value))
    except (TypeError, ValueError) as error:
        raise _BadValueError(_located(path, str(error))) from None


def _as_meant(kind: FieldType, value: object) -> object:
    """Return a scalar of YAML, converted without loss to the type of the field if possible."""
    if kind.base in FLOATS and isinstance(value, str):
        # YAML 1.1 parses 1e-3 as a string, and JSON can write NaN only as a string.
        try:
            return float(value)
        except ValueError:
            return value
    if kind.base in STRINGS and isinstance(value, int | float):
        return str(value)
    if kind.base == "bool" and isinstance(value, int) and value in (0, 1):
        return bool(value)
    if kind.base in INTEGER_RANGES:
        value = _whole(value)
    if (kind.base in INTEGER_RANGES or kind.base in FLOATS) and isinstance(value, bool):
        raise TypeError(expected(kind, value))
    if kind.base == "byte" and isinstance(value, str) and len(value) == 1:
        return ord(value)
    return value


def _whole(value: object) -> object:
    """Return a string or float such as 5.0 as an integer; return other values unchanged."""
    if isinstance(value, str):
        try:
            return int(value)
        except ValueError:
            return value
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _located(path: str, text: str) -> str:
    return f"{path}: {text}" if path else text

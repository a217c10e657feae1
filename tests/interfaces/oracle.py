"""CDR by rosbags, an independent reference for the bytes of every known type."""

from functools import cache
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from teleopctl.interfaces.definition import FieldType, Shape
from teleopctl.interfaces.store import get_message

_UNSIGNED = {"byte": "uint8", "char": "uint8"}


def foreign_bytes(message: Any, little: bool) -> bytes:
    """Return a message as rosbags serialises it."""
    _register(message.TYPE_NAME)
    foreign = _foreign(message)
    return bytes(_store().serialize_cdr(foreign, message.TYPE_NAME, little_endian=little))


@cache
def _store() -> Any:
    return get_typestore(Stores.EMPTY)


@cache
def _register(type_name: str) -> None:
    definition = get_message(type_name).__definition__
    for nested in definition.nested_types():
        _register(nested)
    fields = [(field.attribute, _description(field.type)) for field in definition.wire_fields]
    _store().register({type_name: ([], fields)})


def _description(kind: FieldType) -> Any:
    element = (
        (Nodetype.NAME, kind.base)
        if kind.is_nested
        else (Nodetype.BASE, (_UNSIGNED.get(kind.base, kind.base), kind.string_capacity))
    )
    match kind.shape:
        case Shape.SINGLE:
            return element
        case Shape.ARRAY:
            return (Nodetype.ARRAY, (element, kind.capacity))
    return (Nodetype.SEQUENCE, (element, kind.capacity))


def _foreign(message: Any) -> Any:
    definition = message.__definition__
    values = {
        field.attribute: _foreign_value(field.type, getattr(message, field.attribute))
        for field in definition.fields
    }
    if not values:
        values = {definition.wire_fields[0].name: 0}
    return _store().types[message.TYPE_NAME](**values)


def _foreign_value(kind: FieldType, value: Any) -> Any:
    if kind.is_nested:
        if kind.shape is Shape.SINGLE:
            return _foreign(value)
        return [_foreign(element) for element in value]
    if kind.base == "string":
        return value
    if kind.shape is Shape.SINGLE:
        return value[0] if kind.base == "byte" else value
    if kind.base == "byte":
        return np.frombuffer(b"".join(value), np.uint8)
    return np.array(value, {"bool": np.bool_, "char": np.uint8}.get(kind.base, kind.base))

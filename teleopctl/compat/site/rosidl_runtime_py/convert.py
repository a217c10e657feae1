"""``rosidl_runtime_py.convert``. Messages as text and as dictionaries."""

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import Any

from rosidl_parser.definition import AbstractType

from teleopctl.interfaces import message_to_csv as _csv, message_to_yaml as _yaml, message_values

# Any: messages of any type, and the values of any fields.


def message_to_yaml(
    msg: Any,
    *,
    truncate_length: int | None = None,
    no_arr: bool = False,
    no_str: bool = False,
    flow_style: bool = False,
) -> str:
    """Return a message as YAML; see ``ros2 topic echo`` for the options."""
    return _yaml(msg, truncate=truncate_length, no_arr=no_arr, no_str=no_str, flow=flow_style)


def message_to_csv(
    msg: Any, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> str:
    """Return all values of a message, joined by commas."""
    return _csv(msg, truncate=truncate_length, no_arr=no_arr, no_str=no_str)


def message_to_ordereddict(
    msg: Any, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> "OrderedDict[str, Any]":
    """Return a message as nested dictionaries, cut where the options say so."""
    values = message_values(msg, truncate=truncate_length, no_arr=no_arr, no_str=no_str)
    ordered: OrderedDict[str, Any] = _ordered(values)
    return ordered


def get_message_slot_types(msg: Any) -> "OrderedDict[str, AbstractType]":
    """Return the types of a message's fields by their names."""
    return OrderedDict(zip(msg.get_fields_and_field_types(), msg.SLOT_TYPES, strict=True))


def _ordered(value: Any) -> Any:
    if isinstance(value, dict):
        return OrderedDict((name, _ordered(each)) for name, each in value.items())
    return [_ordered(each) for each in value] if isinstance(value, list) else value


def _convert_value(value: Any, *, truncate_length: int | None = None, **options: bool) -> Any:
    """Return a value that may hold messages as plain ones; rosidl_runtime_py's tests call it."""
    if isinstance(value, bytes):
        value = value.decode("latin-1")
    if hasattr(value, "get_fields_and_field_types"):
        return message_to_ordereddict(value, truncate_length=truncate_length, **options)
    if isinstance(value, Mapping):
        return {
            key: _convert_value(each, truncate_length=truncate_length, **options)
            for key, each in value.items()
        }
    cut = truncate_length is not None and hasattr(value, "__len__") and len(value) > truncate_length
    if isinstance(value, str):
        return value[:truncate_length] + "..." if cut else value
    if isinstance(value, Sequence) or hasattr(value, "__array__"):
        shown = [
            _convert_value(each, truncate_length=truncate_length, **options)
            for each in value[:truncate_length]
        ]
        return (tuple if isinstance(value, tuple) else list)(shown + ["..."] * cut)
    return value.item() if hasattr(value, "item") else value

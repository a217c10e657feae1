"""``rosidl_runtime_py.set_message``. Fields from dictionaries."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from teleopctl.interfaces import message_from_yaml

_STAMPED = {"std_msgs/msg/Header": "auto", "builtin_interfaces/msg/Time": "now"}


# Any: messages of any type.
def set_message_fields(
    msg: Any,
    values: Mapping[str, Any],
    expand_header_auto: bool = False,
    expand_time_now: bool = False,
) -> list[Callable[[Any], None]]:
    """Set fields of a message; those that are not named stay as they are.

    Args:
        msg: The message.
        values: Values by the fields' names; mappings for nested messages.
        expand_header_auto: Whether ``auto`` for a header leaves its stamp to the returned setters.
        expand_time_now: Whether ``now`` for a time leaves it to the returned setters.

    Returns:
        Functions that set one of the stamps left open to a ``builtin_interfaces/msg/Time``.

    Raises:
        AttributeError: The message has no such field.
        TypeError: A value does not fit its field.
        ValueError: A text does not, such as ``'x'`` for a number.
    """
    if not isinstance(values, Mapping):
        got = type(values).__name__
        raise TypeError(f"Value '{values}' is expected to be a dictionary but is a {got}")
    open_stamps: list[Callable[[Any], None]] = []
    for name, value in values.items():
        field = getattr(msg, name)
        type_name = getattr(field, "TYPE_NAME", "")
        word = _STAMPED.get(type_name)
        if word == "auto" and value == word and expand_header_auto:
            open_stamps.append(partial(setattr, field, "stamp"))
        elif word == "now" and value == word and expand_time_now:
            open_stamps.append(partial(setattr, msg, name))
        elif type_name and not isinstance(value, type(field)):
            inner = set_message_fields(field, value, expand_header_auto, expand_time_now)
            open_stamps.extend(inner)
        else:
            try:
                read = message_from_yaml(type(msg), {name: value})
            except Exception as error:
                # As Python's own conversions: int("x") against int([]).
                kind = ValueError if isinstance(value, str) else TypeError
                raise kind(str(error)) from error
            setattr(msg, name, getattr(read, name))
    return open_stamps

"""Types and values of parameters as ROS prints them."""

from __future__ import annotations

# In the order of their numbers.
_TYPE_NAMES = (
    *("not set", "boolean", "integer", "double", "string"),
    *("byte array", "boolean array", "integer array", "double array", "string array"),
)


def type_name(number: int) -> str:
    """The name of a type of ``rcl_interfaces/msg/ParameterType``."""
    return _TYPE_NAMES[number] if 0 <= number < len(_TYPE_NAMES) else "unknown"


def value_label(number: int) -> str:
    """What stands before a value: ``Integer value is:``, ``Integer values are:``."""
    words = type_name(number).split()
    return f"{words[0].capitalize()} {'values are' if len(words) > 1 else 'value is'}:"

"""Types and values of parameters as ROS prints them."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterValue

# In the order of their numbers.
_TYPE_NAMES = (
    *("not set", "boolean", "integer", "double", "string"),
    *("byte array", "boolean array", "integer array", "double array", "string array"),
)


def type_name(number: int) -> str:
    """Return the name of a parameter type number."""
    return _TYPE_NAMES[number] if 0 <= number < len(_TYPE_NAMES) else "unknown"


def value_label(number: int) -> str:
    """Return the label before a value: ``Integer value is:``, ``Integer values are:``."""
    words = type_name(number).split()
    return f"{words[0].capitalize()} {'values are' if len(words) > 1 else 'value is'}:"


def is_set(value: ParameterValue) -> bool:
    """Return whether a declared parameter has a value."""
    return value.type != 0


def value_text(value: ParameterValue, *, hide_type: bool = False) -> str:
    """Return a parameter's value as ``param get`` prints it."""
    if not is_set(value):
        return "None" if hide_type else "Parameter not set."
    from teleopctl.node import parameter_value_to_python

    shown = str(parameter_value_to_python(value))
    return shown if hide_type else f"{value_label(value.type)} {shown}"

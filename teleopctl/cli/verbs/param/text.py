"""Types and values of parameters as ROS prints them."""

from __future__ import annotations

from teleopctl.node import ParameterType

_TYPE_NAMES = {
    ParameterType.NOT_SET: "not set",
    ParameterType.BOOL: "boolean",
    ParameterType.INTEGER: "integer",
    ParameterType.DOUBLE: "double",
    ParameterType.STRING: "string",
    ParameterType.BYTE_ARRAY: "byte array",
    ParameterType.BOOL_ARRAY: "boolean array",
    ParameterType.INTEGER_ARRAY: "integer array",
    ParameterType.DOUBLE_ARRAY: "double array",
    ParameterType.STRING_ARRAY: "string array",
}


def type_name(number: int) -> str:
    """The name of a type of ``rcl_interfaces/msg/ParameterType``."""
    return _TYPE_NAMES[ParameterType(number)] if number in _TYPE_NAMES else "unknown"


def value_label(number: int) -> str:
    """What stands before a value: ``Integer value is:``, ``Integer values are:``."""
    words = type_name(number).split()
    return f"{words[0].capitalize()} {'values are' if len(words) > 1 else 'value is'}:"

"""Errors for values that do not fit a field, in the words of ROS 2's assertions."""

from __future__ import annotations

from teleopctl.interfaces.definition import FLOATS, INTEGER_RANGES, STRINGS, Field, Shape
from teleopctl.interfaces.typenames import split

# ROS 2's message classes raise AssertionError, and Python programs expect TypeError or ValueError:
# these classes are both.


class FieldTypeError(AssertionError, TypeError):
    """Exception for a value of the wrong type for a field, or an argument that is no field."""


class FieldValueError(AssertionError, ValueError):
    """Exception for a value beyond the range, length or bound of its field."""


def field_error(type_name: str, field: Field, error: Exception) -> Exception:
    """Return the FieldTypeError or FieldValueError for a value that a field cannot hold.

    Args:
        type_name: Full name of the message type.
        field: Field that cannot hold the value.
        error: Error of the field's converter.
    """
    kind = FieldTypeError if isinstance(error, TypeError) else FieldValueError
    rule = _rule(field, of_type=kind is FieldTypeError)
    return kind(f"The {field.attribute!r} field must be {rule} ({type_name}: {error})")


def unknown_fields_error(type_name: str, given: list[str], known: list[str]) -> Exception:
    """Return the `FieldTypeError` for constructor arguments that are no fields."""
    names = ", ".join(known) or "none"
    return FieldTypeError(
        f"Invalid arguments passed to constructor: {', '.join(given)} ({type_name} has: {names})"
    )


def _rule(field: Field, *, of_type: bool) -> str:
    """Return the values that a field allows, in the words of rosidl_generator_py's assertions."""
    kind = field.type
    if kind.shape is not Shape.SINGLE:
        return " ".join(("a set or sequence", *_rules_of_elements(field)))
    if kind.is_nested:
        return f"a sub message of type {split(kind.base)[2]!r}"
    if kind.base == "byte":
        return "of type 'bytes' or 'ByteString' with length 1"
    if kind.string_capacity:
        return f"string value not longer than {kind.string_capacity}"
    if of_type or (kind.base not in INTEGER_RANGES and kind.base not in FLOATS):
        return f"of type {_python_type(kind.base)!r}"
    article = "an" if kind.base in INTEGER_RANGES else "a"
    return f"{article} {_range(kind.base)}"


def _rules_of_elements(field: Field) -> list[str]:
    kind = field.type
    rules: list[str] = []
    if kind.shape is Shape.ARRAY:
        rules.append(f"with length {kind.capacity}")
    elif kind.shape is Shape.BOUNDED:
        rules.append(f"with length <= {kind.capacity}")
    if kind.string_capacity:
        rules.append(f"and each string value not longer than {kind.string_capacity}")
    rules.append(f"and each value of type {_python_type(kind.base)!r}")
    if kind.is_numeric:
        rules.append(f"and each {_range(kind.base)}")
    return rules


def _python_type(base: str) -> str:
    if base in INTEGER_RANGES:
        return "int"
    if base in FLOATS:
        return "float"
    if base in STRINGS:
        return "str"
    return {"bool": "bool", "byte": "bytes"}.get(base) or split(base)[2]


def _range(base: str) -> str:
    if base in FLOATS:
        bound = 3.402823466e38 if base == "float32" else 1.7976931348623157e308
        return f"{'float' if base == 'float32' else 'double'} in [{-bound}, {bound}]"
    low, high = INTEGER_RANGES[base]
    return f"{'unsigned ' if low == 0 else ''}integer in [{low}, {high}]"

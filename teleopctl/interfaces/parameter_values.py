"""Python values of ``ParameterValue`` messages."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any, Sequence, TypeAlias, cast
from teleopctl.interfaces.store import get_message

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterValue

# For type checkers an integer is also a float, in arrays too.
AllowableParameterValue: TypeAlias = (
    bool | int | float | str | Sequence[float] | Sequence[str] | Sequence[bytes] | None
)

VALUE_FIELDS = (
    *("", "bool_value", "integer_value", "double_value", "string_value", "byte_array_value"),
    *("bool_array_value", "integer_array_value", "double_array_value", "string_array_value"),
)
"""Field of ``ParameterValue`` that has the value, by number of the `ParameterType`."""

_NOT_SET, _BYTE_ARRAY, _BOOL_ARRAY = 0, 5, 6
_SCALARS = {bool: 1, int: 2, float: 3, str: 4}


def parameter_value_to_python(message: ParameterValue) -> AllowableParameterValue:
    """Return the Python value of a ``ParameterValue`` message; None if not set.

    Raises:
        ValueError: The type number is unknown.
    """
    number = message.type
    if number == _NOT_SET:
        return None
    if number >= len(VALUE_FIELDS):
        raise ValueError(f"{number} is not a valid ParameterType")
    value: Any = getattr(message, VALUE_FIELDS[number])
    if number == _BYTE_ARRAY:
        return [e if isinstance(e, bytes) else bytes([e]) for e in value]
    return cast("AllowableParameterValue", list(value) if number >= _BOOL_ARRAY else value)


def scalar_parameter_value(text: str) -> ParameterValue | None:
    """Return the ``ParameterValue`` of a simple YAML scalar, without PyYAML; None for other texts.

    For commands, which `parameter_value_from_yaml` would delay by 15 ms.
    """
    from teleopctl.interfaces.yaml.plain import read_plain

    plain = (read_plain(f"value: {text}") or {}).get("value")
    number = _SCALARS.get(type(plain))
    if number is None:
        return None
    made: type[ParameterValue] = get_message("rcl_interfaces/msg/ParameterValue")
    message = made(type=number)
    setattr(message, VALUE_FIELDS[number], plain)
    return message

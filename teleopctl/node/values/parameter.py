"""Parameters and parameter types, and their conversion to and from messages."""

from __future__ import annotations

import array
import enum
from collections.abc import Sequence

from teleopctl.base.printable import shortened
from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import (
    VALUE_FIELDS,
    AllowableParameterValue,
    get_message,
    parameter_value_to_python,
)

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterValue


class ParameterType(enum.IntEnum):
    """Parameter types, numbered as in ``rcl_interfaces/msg/ParameterType``."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9

    @classmethod
    def from_parameter_value(cls, value: object) -> ParameterType:
        """Return the parameter type of a Python value.

        An empty sequence is a byte array, as in rclpy; a mix of integers and floats is a double
        array.

        Raises:
            TypeError: No parameter type can hold the value.
        """
        if value is None:
            return cls.NOT_SET
        if isinstance(value, bool):
            return cls.BOOL
        if isinstance(value, int):
            return cls.INTEGER
        if isinstance(value, float):
            return cls.DOUBLE
        if isinstance(value, str):
            return cls.STRING
        if isinstance(value, array.array):
            return cls.DOUBLE_ARRAY if value.typecode in "fd" else cls.INTEGER_ARRAY
        if isinstance(value, bytes | bytearray):
            return cls.BYTE_ARRAY
        if isinstance(value, Sequence):
            return cls._of_elements(value)
        raise TypeError(
            f"The given value is not one of the allowed types '{type(value).__name__}'."
        )

    @classmethod
    def _of_elements(cls, values: Sequence[object]) -> ParameterType:
        kinds = {type(element) for element in values}
        if kinds <= {bytes}:
            return cls.BYTE_ARRAY
        if kinds == {bool}:
            return cls.BOOL_ARRAY
        if kinds == {int}:
            return cls.INTEGER_ARRAY
        if kinds <= {int, float}:
            return cls.DOUBLE_ARRAY
        if kinds == {str}:
            return cls.STRING_ARRAY
        names = ", ".join(sorted(kind.__name__ for kind in kinds))
        raise TypeError(f"The elements of a parameter must be of one type, got {names}.")

    def check(self, value: object) -> bool:
        """Return whether a Python value has this type; an empty sequence has every array type."""
        try:
            actual = ParameterType.from_parameter_value(value)
        except TypeError:
            return False
        if actual == self:
            return True
        # An empty sequence fits every array type.
        empty = isinstance(value, Sequence) and not isinstance(value, str) and not len(value)
        return empty and self >= ParameterType.BYTE_ARRAY


def parameter_value_problem(value: object) -> str | None:
    """Return why a YAML value cannot be a parameter value; None if it can, as null can."""
    try:
        ParameterType.from_parameter_value(value)
    except TypeError as error:
        return str(error).rstrip(".")
    for number in value if isinstance(value, list) else (value,):
        if isinstance(number, int) and not -(2**63) <= number < 2**63:
            return f"{shortened(str(number))} does not fit 64 bits"
    return None


class Parameter:
    """Parameter of a node: name, type and value.

    Args:
        name: Name of the parameter, parts separated by dots.
        type_: Type of the parameter; that of the value if None.
        value: Value of the parameter.

    Raises:
        ValueError: The value is not of the type.
    """

    Type = ParameterType
    __slots__ = ("_name", "_type", "_value")

    def __init__(
        self,
        name: str,
        type_: ParameterType | None = None,
        value: AllowableParameterValue = None,
    ) -> None:
        chosen = ParameterType.from_parameter_value(value) if type_ is None else type_
        if not isinstance(chosen, ParameterType):
            raise TypeError("type must be an instance of 'Parameter.Type'")
        if not chosen.check(value) and value is not None:
            raise ValueError(
                f"Type '{chosen.name}' and value '{shortened(str(value))}' do not agree"
            )
        self._name = name
        self._type = chosen
        # Any: the declaration determines the type, and every program that has just declared the
        # parameter would have to narrow a union.
        self._value: Any = value

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self._name

    @property
    def type_(self) -> ParameterType:
        """Type of the parameter."""
        return self._type

    @property
    def value(self) -> Any:  # Any: see the constructor
        """Value of the parameter; None if it is not set."""
        return self._value

    @classmethod
    def from_parameter_msg(cls, param_msg: ParameterMessage) -> Parameter:
        """Return the parameter that a ``rcl_interfaces/msg/Parameter`` describes."""
        type_ = ParameterType(param_msg.value.type)
        return cls(param_msg.name, type_, parameter_value_to_python(param_msg.value))

    def get_parameter_value(self) -> ParameterValue:
        """Return the value as a ``rcl_interfaces/msg/ParameterValue``."""
        made: type[ParameterValue] = get_message("rcl_interfaces/msg/ParameterValue")
        message = made(type=int(self._type))
        if self._type != ParameterType.NOT_SET:
            value = self._value
            if self._type == ParameterType.DOUBLE_ARRAY:
                value = [float(element) for element in value]
            elif self._type == ParameterType.BYTE_ARRAY:
                value = b"".join(value) if isinstance(value, list) else bytes(value)
            setattr(message, VALUE_FIELDS[self._type], value)
        return message

    def to_parameter_msg(self) -> ParameterMessage:
        """Return the parameter as a ``rcl_interfaces/msg/Parameter``."""
        made: type[ParameterMessage] = get_message("rcl_interfaces/msg/Parameter")
        return made(name=self._name, value=self.get_parameter_value())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Parameter):
            return NotImplemented
        return (self._name, self._type, self._value) == (other._name, other._type, other._value)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Parameter({self._name!r}, {self._type.name}, {self._value!r})"


def parameter_value_from_yaml(text: str) -> ParameterValue:
    """Return the ``ParameterValue`` of a YAML text; the text itself if it is null or fits no type.

    ``1`` is an integer, ``1.0`` a double, ``true`` a boolean, ``[1, 2]`` an integer array; ``"1"``
    and all other texts are strings.
    """
    import yaml

    from teleopctl.base import ros_yaml

    try:
        value = ros_yaml.load_value(text)
        if value is None:
            value = text
        return Parameter("", value=value).get_parameter_value()
    except (yaml.YAMLError, TypeError):
        return Parameter("", value=text).get_parameter_value()

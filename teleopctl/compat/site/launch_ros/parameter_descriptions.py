"""``launch_ros.parameter_descriptions``."""

from __future__ import annotations

import typing
from os import PathLike
from typing import Any

from launch._texts import template
from launch.some_substitutions_type import SomeSubstitutionsType

_SCALARS = (bool, int, float, str)


def type_name(value_type: object) -> str | None:
    """Return the name that the model has for the type of a parameter; None for None.

    Raises:
        TypeError: No parameter has that type.
    """
    if value_type is None:
        return None
    scalar: Any  # a type, as the next lines make sure
    arguments = typing.get_args(value_type)
    scalar = arguments[0] if arguments else value_type
    if scalar not in _SCALARS:
        raise TypeError(f"value_type={value_type} is none of the types that parameters have")
    return f"list_of_{scalar.__name__}" if arguments else scalar.__name__


class ParameterValue:
    """The value of a parameter, with its type where substitutions give it.

    Args:
        value: A value, substitutions, or a list of them.
        value_type: ``int``, ``float``, ``bool``, ``str`` or a list of them; None reads as YAML
            does what substitutions give.

    Raises:
        TypeError: No parameter has that type.
    """

    # Any: see parameters_type. object: a type or a generic alias.
    def __init__(self, value: Any, *, value_type: object | None = None) -> None:
        self.type_name = type_name(value_type)
        self.value = value
        self.value_type = value_type


class Parameter:
    """A parameter by itself.

    Args:
        name: Its name.
        value: Its value.
        value_type: As of `ParameterValue`.
        description: What it is for.
    """

    # Any: see parameters_type. object: a type or a generic alias.
    def __init__(
        self,
        name: SomeSubstitutionsType,
        value: Any,
        *,
        value_type: object | None = None,
        description: SomeSubstitutionsType = "",
    ) -> None:
        self.name = name
        self.parameter_value = ParameterValue(value, value_type=value_type)
        self.description = description

    @property
    def value(self) -> Any:
        """Its value."""
        return self.parameter_value.value


class ParameterFile:
    """A parameter file.

    Args:
        param_file: The file.
        allow_substs: Whether substitutions in it are evaluated.
    """

    def __init__(
        self,
        param_file: PathLike[str] | SomeSubstitutionsType,
        *,
        allow_substs: bool | SomeSubstitutionsType = False,
    ) -> None:
        self.param_file = template(param_file)
        self.allow_substs = allow_substs

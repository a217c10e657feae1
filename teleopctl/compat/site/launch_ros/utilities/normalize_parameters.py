"""``launch_ros.utilities.normalize_parameters``: texts of parameters become substitutions."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from launch.some_substitutions_type import SomeSubstitutionsType_types_tuple
from launch.substitution import Substitution
from launch.substitutions import TextSubstitution
from launch.utilities import ensure_argument_type, normalize_to_list_of_substitutions

from ..parameter_descriptions import Parameter, ParameterFile, ParameterValue
from ..parameters_type import Parameters, ParametersDict, SomeParameters, SomeParametersDict

_ITEMS = (float, int, str, bool, *SomeSubstitutionsType_types_tuple)


def normalize_parameters(parameters: SomeParameters) -> Parameters:
    """Return parameter files, and dictionaries with their texts as substitutions.

    Raises:
        TypeError: There is something among them that is neither.
    """
    if isinstance(parameters, str) or not isinstance(parameters, Sequence):
        raise TypeError(f"Expecting list of parameters, got {parameters}")
    return tuple(
        normalize_parameter_dict(entry)
        if isinstance(entry, Mapping)
        else entry
        if isinstance(entry, Parameter | ParameterFile)
        else ParameterFile(entry)
        for entry in parameters
    )


def normalize_parameter_dict(
    parameters: SomeParametersDict, *, _prefix: Sequence[Substitution] = ()
) -> ParametersDict:
    """Return names and values as substitutions; nested dictionaries become dotted names.

    Raises:
        TypeError: A value is none that a parameter can have.
    """
    if not isinstance(parameters, Mapping):
        raise TypeError("expected dict")
    normalized: ParametersDict = {}
    for key, value in parameters.items():
        name = tuple(normalize_to_list_of_substitutions(key))
        if _prefix:
            name = (*_prefix, TextSubstitution(text="."), *name)
        if isinstance(value, Mapping):
            normalized.update(normalize_parameter_dict(value, _prefix=name))
        else:
            normalized[name] = _value(value)
    return normalized


# Any: see `parameters_type`.
def _value(value: Any) -> Any:
    match value:
        case str():
            return (_quoted(value),)
        case Substitution():
            return (value,)
        case ParameterValue() | float() | bool() | int() | bytes():
            return value
        case Sequence():
            return _array(value)
    raise TypeError(f"Unexpected type for parameter value {value!r}")


def _array(value: Sequence[Any]) -> Any:
    for item in value:
        ensure_argument_type(item, _ITEMS, "subvalue")
    kinds = {
        kind
        for item in value
        for kind in (Substitution, str, bool, int, float, Sequence)
        if isinstance(item, kind) and not (isinstance(item, bool) and kind is int)
        if not (isinstance(item, str) and kind is Sequence)
    }
    if kinds in ({int}, {bool}):
        return tuple(value)
    if kinds in ({float}, {int, float}):
        return tuple(map(float, value))
    if Substitution in kinds and kinds <= {Substitution, str}:
        # As in ROS 2: texts beside substitutions are one text.
        return tuple(normalize_to_list_of_substitutions(value))
    return tuple(
        tuple(normalize_to_list_of_substitutions(_scalar(item) if _is_scalar(item) else item))
        for item in value
    )


def _is_scalar(item: object) -> bool:
    return isinstance(item, float | int | str)


def _scalar(item: object) -> TextSubstitution:
    return _quoted(item) if isinstance(item, str) else TextSubstitution(text=json.dumps(item))


def _quoted(text: str) -> TextSubstitution:
    """Return a text quoted for YAML, in JSON's quotes."""
    return TextSubstitution(text=json.dumps(text, ensure_ascii=False))

"""``launch_ros.utilities.evaluate_parameters``: evaluation of normalized parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml
from launch.launch_context import LaunchContext
from launch.substitution import Substitution
from launch.utilities import ensure_argument_type, perform_substitutions

from teleopctl.base import ros_yaml

from ..parameter_descriptions import Parameter, ParameterFile, ParameterValue
from ..parameters_type import (
    EvaluatedParameters,
    EvaluatedParameterValue,
    Parameters,
    ParametersDict,
)

_SCALARS = (bool, int, float, str)
_AS_TEXT = (
    "If the parameter is meant to be a string, try wrapping it in "
    "launch_ros.parameter_descriptions.ParameterValue(value, value_type=str)"
)


def evaluate_parameters(context: LaunchContext, parameters: Parameters) -> EvaluatedParameters:
    """Return the evaluated parameter files and parameters.

    Args:
        context: Context for the substitutions.
        parameters: Return value of `normalize_parameters`.

    Raises:
        TypeError: A value is none that a parameter can have.
    """
    return tuple(
        entry.evaluate(context)
        if isinstance(entry, ParameterFile)
        else entry
        if isinstance(entry, Parameter)
        else evaluate_parameter_dict(context, entry)
        for entry in parameters
    )


def evaluate_parameter_dict(
    context: LaunchContext, parameters: ParametersDict
) -> dict[str, EvaluatedParameterValue]:
    """Return evaluated parameters by name; see `evaluate_parameters`."""
    if not isinstance(parameters, Mapping):
        raise TypeError("expected dict")
    evaluated = {}
    for key, value in parameters.items():
        if not isinstance(key, tuple):
            raise TypeError(f"Expecting tuple of substitutions got {key!r}")
        name = perform_substitutions(context, key)
        evaluated[name] = _value(context, name, value)
    return evaluated


# Any: see `parameters_type`.
def _value(context: LaunchContext, name: str, value: Any) -> EvaluatedParameterValue:
    if isinstance(value, ParameterValue):
        typed: EvaluatedParameterValue = value.evaluate(context)
        return typed
    if isinstance(value, tuple) and not value:
        raise TypeError(f"given unnormalized parameters {name!r}, {value!r}")
    if not isinstance(value, tuple):
        ensure_argument_type(value, (float, int, str, bool, bytes), "value")
        return value  # type: ignore[no-any-return]  # it is one of these
    if isinstance(value[0], Substitution):
        return _typed(perform_substitutions(context, value), name)
    if isinstance(value[0], Sequence):
        value = [_yaml(perform_substitutions(context, item), name) for item in value]
    return _uniform(value, name)


def _typed(text: str, name: str) -> EvaluatedParameterValue:
    value = _yaml(text, name) if text else ""
    if isinstance(value, (*_SCALARS, bytes)):
        return value
    if isinstance(value, Sequence):
        return _uniform(value, name)
    raise TypeError(
        "Allowed value types are bytes, bool, int, float, str, Sequence[bool], Sequence[int], "
        f"Sequence[float], Sequence[str]. Got {type(value).__name__} for '{name}'. {_AS_TEXT}"
    )


def _yaml(text: str, name: str) -> Any:
    try:
        return ros_yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise TypeError(
            f"Unable to parse the value of parameter {name} as yaml. {_AS_TEXT}"
        ) from error


def _uniform(items: Sequence[Any], name: str) -> EvaluatedParameterValue:
    kind = type(items[0]) if items else None
    if kind not in _SCALARS or not all(isinstance(item, kind) for item in items):
        raise TypeError(
            "Expected a non-empty sequence, with items of uniform type. Allowed sequence item "
            f"types are bool, int, float, str. Got inconsistent input for '{name}'"
        )
    return tuple(items)

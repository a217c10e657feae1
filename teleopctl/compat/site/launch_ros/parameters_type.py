"""``launch_ros.parameters_type``: types of the parameters of a node in a launch file."""

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from launch.some_substitutions_type import SomeSubstitutionsType, SomeSubstitutionsType_types_tuple
from launch.substitution import Substitution

from .parameter_descriptions import Parameter, ParameterFile

# Any: a value is a number, a truth value, a text, substitutions, a list of them, or a mapping;
# names are whatever text a dictionary can have.
SomeParameterName = SomeSubstitutionsType
SomeParameterValue = Any
SomeParameterValue_types_tuple = (
    *SomeSubstitutionsType_types_tuple,
    str,
    int,
    float,
    bool,
    bytes,
)
SomeParametersDict = Mapping[Any, Any]
SomeParameterFile = SomeSubstitutionsType | PathLike[str] | ParameterFile
SomeParameters = Sequence[SomeParameterFile | SomeParametersDict | Parameter]

ParameterName = tuple[Substitution, ...]
ParameterValue = Any
ParametersDict = dict[ParameterName, ParameterValue]
Parameters = Sequence[ParameterFile | ParametersDict | Parameter]

EvaluatedParameterValue = (
    str
    | int
    | float
    | bool
    | bytes
    | Sequence[str]
    | Sequence[int]
    | Sequence[float]
    | Sequence[bool]
)
EvaluatedParameters = Sequence[Path | Parameter | dict[str, EvaluatedParameterValue]]

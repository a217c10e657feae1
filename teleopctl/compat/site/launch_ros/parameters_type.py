"""``launch_ros.parameters_type``."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

from launch.some_substitutions_type import SomeSubstitutionsType

from .parameter_descriptions import Parameter, ParameterFile

# Any: a value is a number, a truth value, a text, substitutions, a list of them, or a mapping.
SomeParametersDict = Mapping[SomeSubstitutionsType, Any]
SomeParameterFile = SomeSubstitutionsType | PathLike[str]
SomeParameters = Sequence[SomeParameterFile | SomeParametersDict | Parameter | ParameterFile]

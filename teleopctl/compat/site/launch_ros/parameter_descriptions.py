"""``launch_ros.parameter_descriptions``."""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterable
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import TYPE_CHECKING, Any, get_args

import yaml
from launch.frontend.parse_substitution import parse_substitution
from launch.some_substitutions_type import SomeSubstitutionsType
from launch.substitution import Substitution
from launch.substitutions import SubstitutionFailure
from launch.utilities import normalize_to_list_of_substitutions, perform_substitutions
from launch.utilities.type_utils import normalize_typed_substitution, perform_typed_substitution

from teleopctl.base import ros_yaml

if TYPE_CHECKING:
    from launch.launch_context import LaunchContext

_SCALARS = (bool, int, float, str)


def type_name(value_type: object) -> str | None:
    """Return the type name in `teleopctl.launch` of a parameter's type; None for None.

    Raises:
        TypeError: No parameter has that type.
    """
    if value_type is None:
        return None
    scalar: Any  # a type, as the next lines make sure
    arguments = get_args(value_type)
    scalar = arguments[0] if arguments else value_type
    if scalar not in _SCALARS:
        raise TypeError(f"value_type={value_type} is none of the types that parameters have")
    return f"list_of_{scalar.__name__}" if arguments else scalar.__name__


class ParameterValue:
    """Value of a parameter, with the type to which its substitutions are converted.

    Args:
        value: A value, substitutions, or a list of them.
        value_type: ``int``, ``float``, ``bool``, ``str`` or a list of them; None reads as YAML
            does what substitutions give.

    Attributes:
        type_name: Name of the type in `teleopctl.launch`.
        normalized: The value with its substitutions as lists of them.

    Raises:
        TypeError: No parameter has that type, or the value cannot become of it.
    """

    # Any: see parameters_type, and a type or a generic alias.
    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self.type_name = type_name(value_type)
        self.normalized = normalize_typed_substitution(value, value_type)
        self._value_type = value_type
        self._evaluated: Any = None

    @property
    def value(self) -> Any:
        """Value; substitutions before evaluation."""
        return self.normalized if self._evaluated is None else self._evaluated

    @property
    def value_type(self) -> Any:
        """Type of the value, or None."""
        return self._value_type

    def evaluate(self, context: LaunchContext) -> Any:
        """Return the value.

        Raises:
            ValueError: The evaluated value is not of its type.
        """
        self._evaluated = perform_typed_substitution(context, self.normalized, self._value_type)
        return self._evaluated


class Parameter:
    """A parameter with its name.

    Args:
        name: Its name.
        value: Its value.
        value_type: As of `ParameterValue`.
        description: Description.
    """

    # Any: see parameters_type, and a type or a generic alias.
    def __init__(
        self,
        name: SomeSubstitutionsType,
        value: Any,
        *,
        value_type: Any = None,
        description: SomeSubstitutionsType = "",
    ) -> None:
        self.normalized_name = normalize_to_list_of_substitutions(name)
        self.parameter_value = ParameterValue(value, value_type=value_type)
        self.description = description
        self._evaluated: tuple[str, Any] | None = None

    @property
    def name(self) -> list[Substitution] | str:
        """Name; substitutions before evaluation."""
        return self.normalized_name if self._evaluated is None else self._evaluated[0]

    @property
    def value(self) -> Any:
        """Value; substitutions before evaluation."""
        return self.parameter_value.value

    @property
    def value_type(self) -> Any:
        """Type of the value, or None."""
        return self.parameter_value.value_type

    def evaluate(self, context: LaunchContext) -> tuple[str, Any]:
        """Return name and value; later calls return the same.

        Raises:
            ValueError: The value turns out not to be of its type.
        """
        if self._evaluated is None:
            name = perform_substitutions(context, self.normalized_name)
            self._evaluated = (name, self.parameter_value.evaluate(context))
        return self._evaluated


class ParameterFile:
    """Parameter file of a node.

    Args:
        param_file: The file.
        allow_substs: Whether substitutions in it are evaluated.

    Attributes:
        given: The file as it was given.
        allows: Whether substitutions are evaluated: a truth value or a list of substitutions.

    Raises:
        TypeError: It is no file, or no truth value.
    """

    def __init__(
        self,
        param_file: os.PathLike[str] | SomeSubstitutionsType,
        *,
        allow_substs: bool | SomeSubstitutionsType = False,
    ) -> None:
        self._remove: weakref.finalize[..., ParameterFile] | None = None
        self._evaluated: tuple[Path, bool] | None = None
        if not isinstance(param_file, str | os.PathLike | Substitution | Iterable):
            raise TypeError(f"ParameterFile() expected a file, got {param_file!r}")
        self.given: os.PathLike[str] | list[Substitution] = (
            param_file
            if isinstance(param_file, os.PathLike)
            else normalize_to_list_of_substitutions(param_file)
        )
        self.allows = normalize_typed_substitution(allow_substs, bool)

    @property
    def param_file(self) -> os.PathLike[str] | list[Substitution]:
        """Path of the file; after evaluation, of the file to read."""
        return self.given if self._evaluated is None else self._evaluated[0]

    # Any: a truth value, or a list of substitutions.
    @property
    def allow_substs(self) -> Any:
        """Whether substitutions in the file are evaluated; a truth value after evaluation."""
        return self.allows if self._evaluated is None else self._evaluated[1]

    def evaluate(self, context: LaunchContext) -> Path:
        """Return the path of the file to read: a temporary one if substitutions are evaluated.

        A launch does this itself for the nodes that it starts, in a file among its logs.

        Raises:
            SubstitutionFailure: The evaluated text is not YAML.
        """
        if self._evaluated is None:
            given = self.given
            path = Path(perform_substitutions(context, given) if isinstance(given, list) else given)
            allows = bool(perform_typed_substitution(context, self.allows, bool))
            if allows:
                path = _written(context, path)
                self._remove = weakref.finalize(self, path.unlink, missing_ok=True)
            self._evaluated = path, allows
        return self._evaluated[0]

    def cleanup(self) -> None:
        """Remove the temporary file, if there is one."""
        if self._remove is not None:
            self._remove()
            self._remove = self._evaluated = None


def _written(context: LaunchContext, path: Path) -> Path:
    text = perform_substitutions(context, parse_substitution(path.read_text(encoding="utf-8")))
    try:
        ros_yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise SubstitutionFailure(
            "The substituted parameter file is not a valid yaml file"
        ) from error
    with NamedTemporaryFile("w", prefix="launch_params_", delete=False, encoding="utf-8") as made:
        made.write(text)
    return Path(made.name)

"""``launch_param_builder.launch_param_builder``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from ament_index_python.packages import get_package_share_directory

from .utils import load_file, load_xacro, load_yaml


class ParameterBuilder:
    """Builder of a parameter dictionary; each method returns the builder.

    Args:
        package_name: The package that paths of files are relative to.

    Raises:
        PackageNotFoundError: The package is unknown.
    """

    def __init__(self, package_name: str) -> None:
        self._package_path = Path(get_package_share_directory(package_name))
        # Any: values of any kind.
        self._parameters: dict[str, Any] = {}

    def yaml(self, file_path: Path | str, parameter_namespace: str | None = None) -> Self:
        """Add the parameters of a YAML file, optionally below a name."""
        into = self._parameters
        if parameter_namespace:
            into = into.setdefault(parameter_namespace, {})
        into.update(load_yaml(self._package_path / file_path))
        return self

    def file_parameter(self, parameter_name: str, file_path: Path | str) -> Self:
        """Add a parameter whose value is the text of a file."""
        return self.parameter(parameter_name, load_file(self._package_path / file_path))

    def xacro_parameter(
        self, parameter_name: str, file_path: Path | str, mappings: Mapping[str, str] | None = None
    ) -> Self:
        """Add a parameter whose value is the expansion of a xacro file."""
        return self.parameter(parameter_name, load_xacro(self._package_path / file_path, mappings))

    # Any: a value of any kind.
    def parameter(self, parameter_name: str, parameter_value: Any) -> Self:
        """Add a parameter."""
        self._parameters[parameter_name] = parameter_value
        return self

    def path_parameter(self, parameter_name: str, file_path: Path | str) -> Self:
        """Add a parameter whose value is the path of a file."""
        return self.parameter(parameter_name, str(self._package_path / file_path))

    def to_dict(self) -> dict[str, Any]:
        """Return all parameters by name."""
        return self._parameters

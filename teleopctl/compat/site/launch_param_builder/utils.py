"""``launch_param_builder.utils``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from ament_index_python.packages import get_package_share_directory

from teleopctl.robot import expand_xacro

ParameterValueType = (
    str | int | float | bool | list[str] | list[int] | list[float] | list[bool] | bytes
)


class ParameterBuilderFileNotFoundError(KeyError):
    """Raised when a parameter file does not exist."""

    def __str__(self) -> str:
        # A KeyError would print its message with the quotes of a key.
        return str(self.args[0])


def raise_if_file_not_found(file_path: Path | str) -> None:
    """Raise if a file does not exist.

    Raises:
        ParameterBuilderFileNotFoundError: The file does not exist.
    """
    if not Path(file_path).exists():
        raise ParameterBuilderFileNotFoundError(f"File {file_path} doesn't exist")


def load_file(file_path: Path | str) -> str:
    """Return the text of a file.

    Raises:
        ParameterBuilderFileNotFoundError: The file does not exist.
    """
    raise_if_file_not_found(file_path)
    return Path(file_path).read_text(encoding="utf-8")


# Any: what a YAML file holds.
def load_yaml(file_path: Path | str) -> Any:
    """Return the content of a YAML file.

    Raises:
        ParameterBuilderFileNotFoundError: The file does not exist.
        yaml.YAMLError: It is not YAML; the message has file and line.
    """
    raise_if_file_not_found(file_path)
    with Path(file_path).open(encoding="utf-8") as file:
        return yaml.safe_load(file)


def load_xacro(file_path: Path | str, mappings: Mapping[str, str] | None = None) -> str:
    """Return the expansion of a xacro file.

    Args:
        file_path: The file.
        mappings: Values of its ``<xacro:arg>`` by name.

    Raises:
        ParameterBuilderFileNotFoundError: The file does not exist.
        InvalidDescriptionError: It cannot be expanded; the message has file and line.
    """
    raise_if_file_not_found(file_path)
    return expand_xacro(file_path, mappings)


def get_path(package_name: str, file_path: str) -> str:
    """Return the path of a file of a package, whether it exists or not.

    Raises:
        PackageNotFoundError: The package is unknown.
    """
    return str(Path(get_package_share_directory(package_name)) / file_path)

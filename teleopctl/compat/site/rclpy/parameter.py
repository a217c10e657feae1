"""``rclpy.parameter``. Parameters."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl import interfaces
from teleopctl.errors import InvalidFileError
from teleopctl.node import Parameter, parameter_messages, parameter_value_from_yaml

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterValue

    from teleopctl.interfaces import AllowableParameterValue

__all__ = [
    "PARAMETER_SEPARATOR_STRING",
    "Parameter",
    "get_parameter_value",
    "parameter_dict_from_yaml_file",
    "parameter_value_to_python",
]

PARAMETER_SEPARATOR_STRING = "."


def get_parameter_value(string_value: str) -> "ParameterValue":
    """Return the value of a YAML text as a message."""
    return parameter_value_from_yaml(string_value)


def parameter_value_to_python(parameter_value: "ParameterValue") -> "AllowableParameterValue":
    """Return the Python value of a message.

    Raises:
        RuntimeError: The message is of no type that there is.
    """
    try:
        return interfaces.parameter_value_to_python(parameter_value)
    except ValueError as error:
        raise RuntimeError(f"unexpected parameter type {parameter_value.type}") from error


def parameter_dict_from_yaml_file(
    parameter_file: str | Path,
    use_wildcard: bool = False,
    target_nodes: Sequence[str] | None = None,
    namespace: str = "",
) -> "dict[str, ParameterMessage]":
    """Return the parameters in a file as messages, by name; see `parameter_messages`.

    Raises:
        OSError: The file cannot be read.
        RuntimeError: It is no parameter file, or has nothing for a node that is named.
        TypeError: A value is none that parameters can have.
    """
    with Path(parameter_file).open():  # raises what rclpy raises
        pass
    try:
        return parameter_messages(parameter_file, use_wildcard, target_nodes, namespace)
    except InvalidFileError as error:
        raise RuntimeError(error.message) from error


if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)

"""``launch_param_builder``: node parameters from the files of a package, for launch files."""

from .launch_param_builder import ParameterBuilder
from .utils import (
    ParameterBuilderFileNotFoundError,
    ParameterValueType,
    get_path,
    load_file,
    load_xacro,
    load_yaml,
    raise_if_file_not_found,
)

__all__ = [
    "ParameterBuilder",
    "ParameterBuilderFileNotFoundError",
    "ParameterValueType",
    "get_path",
    "load_file",
    "load_xacro",
    "load_yaml",
    "raise_if_file_not_found",
]

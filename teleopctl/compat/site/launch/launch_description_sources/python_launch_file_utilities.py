"""``launch.launch_description_sources.python_launch_file_utilities``."""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from os import PathLike, fspath
from types import ModuleType

from ..launch_description import LaunchDescription

_FUNCTION = "generate_launch_description"


class InvalidPythonLaunchFileError(Exception):
    """Raised when a Python file is not a valid launch file."""


def load_python_launch_file_as_module(python_launch_file_path: str | PathLike[str]) -> ModuleType:
    """Return the module of a Python launch file of any extension."""
    loader = SourceFileLoader("python_launch_file", fspath(python_launch_file_path))
    spec = spec_from_loader(loader.name, loader)
    assert spec is not None
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module


def get_launch_description_from_python_launch_file(
    python_launch_file_path: str | PathLike[str],
) -> LaunchDescription:
    """Return the launch description of a Python file.

    Raises:
        InvalidPythonLaunchFileError: It has no ``generate_launch_description``.
    """
    module = load_python_launch_file_as_module(python_launch_file_path)
    function = getattr(module, _FUNCTION, None)
    if function is None:
        raise InvalidPythonLaunchFileError(
            f"launch file at '{fspath(python_launch_file_path)}' does not contain the required "
            f"function '{_FUNCTION}()'"
        )
    described: LaunchDescription = function()
    return described

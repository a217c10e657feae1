"""The front end of Python launch files: ``generate_launch_description()``."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

from teleopctl.compat.activation import SITE, activate, set_variables
from teleopctl.errors import LaunchError
from teleopctl.launch import LaunchFile, take_temporary_files

_FUNCTION = "generate_launch_description"


def read(path: Path) -> LaunchFile:
    """Run a Python launch file; return its path and the steps of its launch description.

    Raises:
        TeleopctlError: The file cannot be read, has no function ``generate_launch_description``, or
            raises an error; the message has file and line.
    """
    prefer_own_packages()
    take_temporary_files()
    from launch import LaunchDescription
    from launch._entities import steps
    from launch._places import blamed

    name = f"_launch_file_{path.name.partition('.')[0]}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        function = getattr(module, _FUNCTION, None)
        if function is None:
            raise LaunchError(
                f"launch file at '{path}' does not contain the required function '{_FUNCTION}()'"
            )
        description = function()
        if not isinstance(description, LaunchDescription):
            raise LaunchError(
                f"{_FUNCTION}() returned {type(description).__name__}, expected a LaunchDescription"
            )
        return LaunchFile(
            path, steps(description.with_warning(f"launch file [{path}] is deprecated"))
        )
    except FileNotFoundError as error:
        if error.filename == str(path):
            raise LaunchError(f"there is no launch file {path}") from error
        raise blamed(error, str(path)) from error
    except SyntaxError as error:
        raise LaunchError(f"{error.filename}:{error.lineno}: {error.msg}") from error
    except Exception as error:
        raise blamed(error, str(path)) from error


def prefer_own_packages() -> None:
    """Make ``import launch`` and so on load teleopctl's packages, even beside a real ROS 2.

    teleopctl evaluates the launch, so the classes have to be teleopctl's.
    """
    activate()
    set_variables()
    if sys.path[0] != SITE:
        sys.path.insert(0, SITE)

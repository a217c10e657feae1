"""Readers of launch files: each turns one language into `teleopctl.launch.model`."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from teleopctl.errors import LaunchError
from teleopctl.launch.model.action import LaunchFile

# Which folder beside this file reads what; its `parser` has the function `parse_file`. A language
# that is not used is not imported.
_LANGUAGES = {
    ".yaml": "yaml",
    ".yml": "yaml",
    ".xml": "xml",
    ".launch": "xml",
}


def read_launch_file(path: Path) -> LaunchFile:
    """Read a launch file, in the language that its ending says.

    Raises:
        TeleopctlError: It cannot be read or does not follow the vocabulary. The message names file
            and line, and what was expected there.
    """
    language = _LANGUAGES.get(path.suffix)
    if language is None:
        raise LaunchError(
            f"{path} is no launch file that teleopctl reads",
            hint=f"It reads ROS 2's launch files that end in {', '.join(_LANGUAGES)}.",
        )
    parser = import_module(f"{__name__}.{language}.parser")
    parse_file: Callable[[Path], LaunchFile] = parser.parse_file
    return parse_file(path)

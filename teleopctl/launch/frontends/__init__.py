"""Readers of launch files: each turns one language into `teleopctl.launch.model`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from teleopctl import plugins
from teleopctl.errors import LaunchError, UnknownPluginError
from teleopctl.launch.model.action import LaunchFile


def read_launch_file(path: Path) -> LaunchFile:
    """Read a launch file, in the language that its ending says.

    Raises:
        TeleopctlError: It cannot be read or does not follow the vocabulary. The message names file
            and line, and what was expected there.
    """
    try:
        read: Callable[[Path], LaunchFile] = plugins.load(plugins.LAUNCH_LANGUAGES, path.suffix)
    except UnknownPluginError as error:
        endings = sorted(plugins.available(plugins.LAUNCH_LANGUAGES))
        raise LaunchError(
            f"{path} is no launch file that teleopctl reads",
            hint=f"It reads ROS 2's launch files that end in {', '.join(endings)}.",
        ) from error
    return read(path)

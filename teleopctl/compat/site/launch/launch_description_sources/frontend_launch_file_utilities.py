"""``launch.launch_description_sources.frontend_launch_file_utilities``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from teleopctl.errors import TeleopctlError
from teleopctl.launch import read_launch_file

from ..invalid_launch_file_error import InvalidLaunchFileError
from ..launch_description import LaunchDescription
from ._reading import ReadStep


class InvalidFrontendLaunchFileError(InvalidLaunchFileError):
    """A file is no launch file that is a text."""


# Any: the original's parser class, of which nothing is used.
def get_launch_description_from_frontend_launch_file(
    frontend_launch_file_path: str,
    *,
    parser: Any = None,  # noqa: ARG001 -- the original's signature
) -> LaunchDescription:
    """Return what stands in a launch file that is a text.

    Raises:
        InvalidFrontendLaunchFileError: It is none.
    """
    path = Path(frontend_launch_file_path)
    try:
        return LaunchDescription([ReadStep(step) for step in read_launch_file(path).steps])
    except TeleopctlError as error:
        raise InvalidFrontendLaunchFileError(path.suffix[1:], likely_errors=[error]) from error

"""``launch.launch_description_sources.frontend_launch_file_utilities``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from teleopctl.errors import TeleopctlError
from teleopctl.launch import read_launch_file

from ..frontend.known import action_of
from ..invalid_launch_file_error import InvalidFrontendLaunchFileError
from ..launch_description import LaunchDescription


# Any: the original's parser class, of which nothing is used.
def get_launch_description_from_frontend_launch_file(
    frontend_launch_file_path: str,
    *,
    parser: Any = None,  # noqa: ARG001 -- the original's signature
) -> LaunchDescription:
    """Return the launch description of an XML or YAML file.

    Raises:
        InvalidFrontendLaunchFileError: The file is not a launch file.
    """
    path = Path(frontend_launch_file_path)
    try:
        return LaunchDescription([action_of(step) for step in read_launch_file(path).steps])
    except TeleopctlError as error:
        raise InvalidFrontendLaunchFileError(path.suffix[1:], likely_errors=[error]) from error

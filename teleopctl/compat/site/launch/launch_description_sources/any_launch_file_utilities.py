"""``launch.launch_description_sources.any_launch_file_utilities``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..launch_description import LaunchDescription
from .frontend_launch_file_utilities import get_launch_description_from_frontend_launch_file
from .python_launch_file_utilities import get_launch_description_from_python_launch_file


# Any: the original's parser class, of which nothing is used.
def get_launch_description_from_any_launch_file(
    launch_file_path: str,
    *,
    parser: Any = None,  # noqa: ARG001 -- the original's signature
) -> LaunchDescription:
    """Return the launch description of a file, by its extension.

    Raises:
        InvalidLaunchFileError: The file is not a launch file.
    """
    if Path(launch_file_path).suffix == ".py":
        return get_launch_description_from_python_launch_file(launch_file_path)
    return get_launch_description_from_frontend_launch_file(launch_file_path)

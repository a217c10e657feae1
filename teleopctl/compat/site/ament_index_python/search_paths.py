"""``ament_index_python.search_paths``: the install prefixes that a terminal has sourced."""

import contextlib
import os

from ament_index_python.constants import AMENT_PREFIX_PATH_ENV_VAR
from teleopctl.errors import SystemFailureError
from teleopctl.packages import search_paths

__all__ = ["get_search_paths"]

# A sourced ROS 2 always has the variable; so has a process that imports this module.
if not os.environ.get(AMENT_PREFIX_PATH_ENV_VAR):
    with contextlib.suppress(SystemFailureError):  # no folder to write to
        os.environ[AMENT_PREFIX_PATH_ENV_VAR] = os.pathsep.join(search_paths())


def get_search_paths() -> list[str]:
    """Return the prefixes that ``AMENT_PREFIX_PATH`` names and that exist.

    Raises:
        OSError: The process has removed the variable, or emptied it.
    """
    if not os.environ.get(AMENT_PREFIX_PATH_ENV_VAR):
        raise OSError(f"Environment variable '{AMENT_PREFIX_PATH_ENV_VAR}' is not set or empty")
    return search_paths()

"""``ament_index_python.search_paths``: the install prefixes that a terminal has sourced."""

import os

from ament_index_python.constants import AMENT_PREFIX_PATH_ENV_VAR
from teleopctl.packages import search_paths

__all__ = ["get_search_paths"]


def get_search_paths() -> list[str]:
    """Return the prefixes that ``AMENT_PREFIX_PATH`` names and that exist.

    Raises:
        OSError: The variable is not set, or empty.
    """
    if not os.environ.get(AMENT_PREFIX_PATH_ENV_VAR):
        raise OSError(f"Environment variable '{AMENT_PREFIX_PATH_ENV_VAR}' is not set or empty")
    return search_paths()

"""``ament_index_python.search_paths``: the install prefixes that a terminal has sourced."""

from teleopctl.packages import search_paths

__all__ = ["get_search_paths"]


def get_search_paths() -> list[str]:
    """Return the prefixes that ``AMENT_PREFIX_PATH`` names and that exist.

    If the variable is not set or empty, ROS 2 raises an error; here it is the prefix of teleopctl's
    own packages, and that of Python if it has ROS packages.
    """
    return search_paths()

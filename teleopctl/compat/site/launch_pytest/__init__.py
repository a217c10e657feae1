"""ROS 2's ``launch_pytest``: pytest functions beside processes that a launch description starts."""

from . import actions, tools
from .fixture import fixture

__all__ = ["actions", "fixture", "tools"]

"""ROS 2's ``launch_pytest``: pytest functions that run with a launch description."""

from . import actions, tools
from .fixture import fixture

__all__ = ["actions", "fixture", "tools"]

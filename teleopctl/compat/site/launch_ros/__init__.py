"""ROS 2's ``launch_ros``: nodes, their parameters and their packages in Python launch files."""

from . import actions, descriptions, substitutions

__all__ = ["actions", "descriptions", "substitutions"]

"""ROS 2's ``launch_yaml``: source and parser of YAML launch files."""

from launch.frontend.entity import Entity

from . import launch_description_sources
from .parser import Parser

__all__ = ["Entity", "Parser", "launch_description_sources"]

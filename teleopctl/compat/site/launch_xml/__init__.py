"""ROS 2's ``launch_xml``: an XML launch file as what a Python one includes."""

from launch.frontend.entity import Entity

from . import launch_description_sources
from .parser import Parser

__all__ = ["Entity", "Parser", "launch_description_sources"]

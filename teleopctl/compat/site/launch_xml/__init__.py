"""ROS 2's ``launch_xml``: an XML launch file as what a Python one includes."""

from . import launch_description_sources

__all__ = ["launch_description_sources"]

"""ROS 2's ``launch_yaml``: a YAML launch file as what a Python one includes."""

from . import launch_description_sources

__all__ = ["launch_description_sources"]

"""The ROS 2 workflow in one pip install."""

__version__ = "0.1.0"

"""``launch_ros.events``."""

from . import lifecycle, matchers

__all__ = ["lifecycle", "matchers"]

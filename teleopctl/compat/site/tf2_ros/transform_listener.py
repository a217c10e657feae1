"""``tf2_ros.transform_listener``. What fills a buffer."""

from teleopctl.tf import TransformListener

__all__ = ["TransformListener"]

"""``ros_gz_bridge.actions``."""

from .ros_gz_bridge import RosGzBridge

__all__ = ["RosGzBridge"]

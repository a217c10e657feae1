"""``rclpy.impl.rcutils_logger``. The logger class."""

from teleopctl.node.logging import RcutilsLogger

__all__ = ["RcutilsLogger"]

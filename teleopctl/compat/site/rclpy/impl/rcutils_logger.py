"""``rclpy.impl.rcutils_logger``. The logger class."""

from teleopctl.node import RcutilsLogger

__all__ = ["RcutilsLogger"]

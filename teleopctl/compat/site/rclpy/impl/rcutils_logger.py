"""``rclpy.impl.rcutils_logger``. The logger class."""

from teleopctl.node.values.logging import RcutilsLogger

__all__ = ["RcutilsLogger"]

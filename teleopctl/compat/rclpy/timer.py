"""``rclpy.timer``. Timers and rates."""

from teleopctl.node.timer import Rate, Timer

__all__ = ["Rate", "Timer"]

"""``rclpy.timer``. Timers and rates."""

from teleopctl.node import Rate, Timer

__all__ = ["Rate", "Timer"]

"""``rclpy.timer``. Timers and rates."""

from teleopctl.node.endpoints.timer import Rate, Timer

__all__ = ["Rate", "Timer"]

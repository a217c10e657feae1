"""``rclpy.task``. Futures and tasks."""

from teleopctl.node import Future, Task

__all__ = ["Future", "Task"]

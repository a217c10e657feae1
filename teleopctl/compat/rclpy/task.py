"""``rclpy.task``. Futures and tasks."""

from teleopctl.node.future import Future, Task

__all__ = ["Future", "Task"]

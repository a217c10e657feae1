"""``rclpy.task``. Futures and tasks."""

from teleopctl.node.values.future import Future, Task

__all__ = ["Future", "Task"]

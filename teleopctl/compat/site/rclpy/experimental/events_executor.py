"""``rclpy.experimental.events_executor``. Every executor here works by events."""

from teleopctl.node.executor import SingleThreadedExecutor as EventsExecutor

__all__ = ["EventsExecutor"]

"""``rclpy.experimental``. The events executor."""

from rclpy.experimental.events_executor import EventsExecutor

__all__ = ["EventsExecutor"]

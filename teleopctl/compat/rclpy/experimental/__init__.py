"""``rclpy.experimental``. The events executor."""

from teleopctl.compat.rclpy.experimental.events_executor import EventsExecutor

__all__ = ["EventsExecutor"]

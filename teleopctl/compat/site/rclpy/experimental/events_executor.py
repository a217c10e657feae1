"""``rclpy.experimental.events_executor``. Every executor here works by events."""

from teleopctl.node import SingleThreadedExecutor as EventsExecutor

__all__ = ["EventsExecutor"]

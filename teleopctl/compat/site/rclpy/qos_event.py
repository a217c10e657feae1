"""``rclpy.qos_event``. The name that `rclpy.event_handler` had in earlier distributions."""

from rclpy import event_handler
from rclpy.event_handler import *  # noqa: F403 -- the same names

__all__ = event_handler.__all__

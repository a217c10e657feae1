"""``rclpy.lifecycle.publisher``. Publishers that send only while their node is active."""

from teleopctl.node import LifecyclePublisher

__all__ = ["LifecyclePublisher"]

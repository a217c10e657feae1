"""``rclpy.type_hash``. Hashes of types."""

from teleopctl.node import TypeHash

__all__ = ["TypeHash"]

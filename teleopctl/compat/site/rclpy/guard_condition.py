"""``rclpy.guard_condition``. Guard conditions."""

from teleopctl.node import GuardCondition

__all__ = ["GuardCondition"]

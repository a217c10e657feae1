"""``rclpy.guard_condition``. Guard conditions."""

from teleopctl.node.endpoints.guard_condition import GuardCondition

__all__ = ["GuardCondition"]

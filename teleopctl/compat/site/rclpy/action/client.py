"""``rclpy.action.client``. Action clients."""

from teleopctl.node import ActionClient, ClientGoalHandle

__all__ = ["ActionClient", "ClientGoalHandle"]

"""``ros2cli.node``. Nodes of command-line tools."""

from rclpy.node import HIDDEN_NODE_PREFIX

__all__ = ["NODE_NAME_PREFIX"]

NODE_NAME_PREFIX = f"{HIDDEN_NODE_PREFIX}ros2cli"

"""``rclpy.node``. Nodes."""

from teleopctl.node.client import Client
from teleopctl.node.node import Node
from teleopctl.node.parameter import Parameter
from teleopctl.node.publisher import Publisher
from teleopctl.node.service import Service
from teleopctl.node.subscription import Subscription
from teleopctl.node.timer import Rate, Timer

__all__ = ["Client", "Node", "Parameter", "Publisher", "Rate", "Service", "Subscription", "Timer"]

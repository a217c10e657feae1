"""``rclpy.node``. Nodes."""

from teleopctl.node.endpoints.client import Client
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.endpoints.service import Service
from teleopctl.node.endpoints.subscription import Subscription
from teleopctl.node.endpoints.timer import Rate, Timer
from teleopctl.node.node import Node
from teleopctl.node.values.parameter import Parameter

__all__ = ["Client", "Node", "Parameter", "Publisher", "Rate", "Service", "Subscription", "Timer"]

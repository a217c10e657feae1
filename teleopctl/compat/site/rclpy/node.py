"""``rclpy.node``. Nodes."""

from teleopctl.node import Client, Node, Parameter, Publisher, Rate, Service, Subscription, Timer

__all__ = ["Client", "Node", "Parameter", "Publisher", "Rate", "Service", "Subscription", "Timer"]

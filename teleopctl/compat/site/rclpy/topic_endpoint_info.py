"""``rclpy.topic_endpoint_info``. Description of endpoints in the graph."""

from teleopctl.node import TopicEndpointInfo, TopicEndpointTypeEnum

__all__ = ["TopicEndpointInfo", "TopicEndpointTypeEnum"]

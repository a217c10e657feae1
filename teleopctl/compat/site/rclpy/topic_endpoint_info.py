"""``rclpy.topic_endpoint_info``. What the graph tells of an endpoint."""

from teleopctl.node import TopicEndpointInfo, TopicEndpointTypeEnum

__all__ = ["TopicEndpointInfo", "TopicEndpointTypeEnum"]

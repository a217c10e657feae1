"""``rclpy.topic_endpoint_info``. What the graph tells of an endpoint."""

from teleopctl.node.values.endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum

__all__ = ["TopicEndpointInfo", "TopicEndpointTypeEnum"]

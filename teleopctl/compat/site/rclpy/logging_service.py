"""``rclpy.logging_service``. Services that get and set the levels of a node's loggers."""

from teleopctl.node import LoggerService as LoggingService

__all__ = ["LoggingService"]

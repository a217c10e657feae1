"""``rclpy.signals``. Which signals a context heeds."""

from teleopctl.node.signals import SignalHandlerOptions

__all__ = ["SignalHandlerOptions"]

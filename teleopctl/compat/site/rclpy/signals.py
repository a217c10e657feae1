"""``rclpy.signals``. Which signals a context heeds."""

from teleopctl.node.values.signals import SignalHandlerOptions

__all__ = ["SignalHandlerOptions"]

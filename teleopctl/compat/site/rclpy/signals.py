"""``rclpy.signals``. Which signals a context heeds."""

from teleopctl.node import SignalHandlerOptions

__all__ = ["SignalHandlerOptions"]

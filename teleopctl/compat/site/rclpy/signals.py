"""``rclpy.signals``. Which signals a context heeds."""

from teleopctl.node import SignalHandlerOptions, heeded_signals

__all__ = ["SignalHandlerOptions", "get_current_signal_handlers_options"]

get_current_signal_handlers_options = heeded_signals

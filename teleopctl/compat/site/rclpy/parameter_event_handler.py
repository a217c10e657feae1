"""``rclpy.parameter_event_handler``. Callbacks for changes of parameters."""

from teleopctl.node import (
    ParameterCallbackHandle,
    ParameterEventCallbackHandle,
    ParameterEventHandler,
)

__all__ = ["ParameterCallbackHandle", "ParameterEventCallbackHandle", "ParameterEventHandler"]

"""``rclpy.parameter_event_handler``. Callbacks for changes of parameters."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import (
    ParameterCallbackHandle,
    ParameterEventCallbackHandle,
    ParameterEventHandler,
)

__all__ = ["ParameterCallbackHandle", "ParameterEventCallbackHandle", "ParameterEventHandler"]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)

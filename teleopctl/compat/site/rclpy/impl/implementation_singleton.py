"""``rclpy.impl.implementation_singleton``. What programs catch and compare from the C library."""

from types import SimpleNamespace

from teleopctl.node import (
    InvalidHandle,
    LifecycleStateMachine,
    RCLError,
    TransitionCallbackReturn,
)

__all__ = ["rclpy_implementation"]

rclpy_implementation = SimpleNamespace(
    InvalidHandle=InvalidHandle,
    LifecycleStateMachine=LifecycleStateMachine,
    RCLError=RCLError,
    TransitionCallbackReturnType=TransitionCallbackReturn,
)

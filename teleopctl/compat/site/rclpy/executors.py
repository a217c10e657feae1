"""``rclpy.executors``. Executors."""

from typing import TYPE_CHECKING

from rclpy._imported import imported
from teleopctl.node import (
    ConditionReachedException,
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)

__all__ = [
    "ConditionReachedException",
    "Executor",
    "ExternalShutdownException",
    "MultiThreadedExecutor",
    "ShutdownException",
    "SingleThreadedExecutor",
    "TimeoutException",
]

if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)

"""``rclpy.executors``. Executors."""

from teleopctl.node.exceptions import (
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
)
from teleopctl.node.executor import Executor, MultiThreadedExecutor, SingleThreadedExecutor

__all__ = [
    "ConditionReachedException",
    "Executor",
    "ExternalShutdownException",
    "MultiThreadedExecutor",
    "ShutdownException",
    "SingleThreadedExecutor",
    "TimeoutException",
]

"""``rclpy.executors``. Executors."""

from teleopctl.node.executor import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from teleopctl.node.values.exceptions import (
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
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

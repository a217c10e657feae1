"""``rclpy.executors``. Executors, and names that executors of programs use."""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy._imported import imported
from teleopctl.node import (
    ConditionReachedException,
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    Node,
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
    "TaskData",
    "TimeoutException",
    "TimeoutObject",
    "WaitableEntityType",
    "await_or_execute",
]

WaitableEntityType = TypeVar("WaitableEntityType")


@dataclass
class TaskData:
    """Node and entity that the callback of a task belongs to; None if it belongs to none."""

    source_node: Node | None = None
    source_entity: object = None


class TimeoutObject:
    """Timeout in seconds that can be changed while something waits by it."""

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout


# Any: arguments and result of a callback of the program.
async def await_or_execute(
    callback: Callable[..., Any] | Callable[..., Coroutine[Any, Any, Any]], *args: Any
) -> Any:
    """Call a function, or a coroutine function and await it; return the result."""
    outcome = callback(*args)
    return await outcome if isinstance(outcome, Coroutine) else outcome


if not TYPE_CHECKING:  # checkers know the documented names only
    __getattr__ = imported(__name__)

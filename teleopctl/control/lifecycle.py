"""Lifecycle states and return values of controllers and hardware, named as in ros2_control."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from teleopctl.errors import TeleopctlError
from teleopctl.node import PrimaryState as State, TransitionCallbackReturn as CallbackReturn

__all__ = [
    "CallbackReturn",
    "OnException",
    "ReturnType",
    "State",
    "handle_exception",
    "raise_exception",
]

OnException = Callable[[str, BaseException], object]
"""Called with an exception of a controller or hardware: what raised it, in a sentence, and it."""


def handle_exception(what: str, error: BaseException) -> None:
    """Do nothing more about an exception, whose callback then counts as failed: an `OnException`.

    It is that of ``handle_exceptions: true``, the default of the controller manager's parameter.
    """
    del what, error


def raise_exception(what: str, error: BaseException) -> None:
    """Raise an exception again, unless it is a foreseen failure (TeleopctlError)."""
    del what
    if not isinstance(error, TeleopctlError):
        raise error


class ReturnType(Enum):
    """Return values of ``update``, ``read`` and ``write``; None is OK, an exception is ERROR."""

    OK = "ok"
    ERROR = "error"
    DEACTIVATE = "deactivate"

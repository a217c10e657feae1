"""Lifecycle states and return values of controllers and hardware, named as in ros2_control."""

from __future__ import annotations

from enum import Enum

from teleopctl.node import PrimaryState as State, TransitionCallbackReturn as CallbackReturn

__all__ = ["CallbackReturn", "ReturnType", "State"]


class ReturnType(Enum):
    """Return values of ``update``, ``read`` and ``write``; None is OK, an exception is ERROR."""

    OK = "ok"
    ERROR = "error"
    DEACTIVATE = "deactivate"

"""Life cycles: the states of controllers and hardware, and what their callbacks return."""

from __future__ import annotations

from enum import Enum

from teleopctl.node import PrimaryState as State, TransitionCallbackReturn as CallbackReturn

__all__ = ["CallbackReturn", "ReturnType", "State"]


class ReturnType(Enum):
    """Return value of update, read and write; None means OK, an exception means ERROR."""

    OK = "ok"
    ERROR = "error"
    DEACTIVATE = "deactivate"

"""Life cycles: the states of controllers and hardware, and what their callbacks return."""

from __future__ import annotations

from enum import Enum, IntEnum


class State(IntEnum):
    """Primary states with the ids of lifecycle_msgs/State."""

    UNKNOWN = 0
    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3
    FINALIZED = 4

    @property
    def label(self) -> str:
        """The state as ROS 2 writes it."""
        return self.name.lower()


class CallbackReturn(Enum):
    """Outcome of a life cycle callback; returning None means SUCCESS, raising means ERROR."""

    SUCCESS = "success"
    FAILURE = "failure"
    ERROR = "error"


class ReturnType(Enum):
    """Outcome of update, read or write; returning None means OK, raising means ERROR."""

    OK = "ok"
    ERROR = "error"
    DEACTIVATE = "deactivate"

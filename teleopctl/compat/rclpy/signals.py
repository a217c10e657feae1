"""``rclpy.signals``. Which signals a context handles."""

import enum

__all__ = ["SignalHandlerOptions"]


class SignalHandlerOptions(enum.IntEnum):
    """Accepted by ``rclpy.init``: SIGTERM always ends the context, Ctrl-C always interrupts."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3

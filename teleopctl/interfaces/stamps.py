"""Conversions between nanoseconds and ``builtin_interfaces`` Time and Duration.

Both messages have ``int32 sec`` and ``uint32 nanosec``, and mean ``sec + nanosec / 10**9`` seconds
with nanosec below 10**9. The seconds of a negative time are therefore rounded down, as in rcl:
-0.25 s is sec -1, nanosec 750000000.
"""

from __future__ import annotations

from teleopctl.base.typed import Protocol

NANOSECONDS_PER_SECOND = 1_000_000_000


class Stamp(Protocol):
    """Interface of a ``builtin_interfaces`` Time or Duration."""

    sec: int
    nanosec: int


def to_nanoseconds(stamp: Stamp) -> int:
    """Return a Time or Duration in nanoseconds."""
    return stamp.sec * NANOSECONDS_PER_SECOND + stamp.nanosec


def set_stamp(stamp: Stamp, nanoseconds: int) -> None:
    """Set ``sec`` and ``nanosec`` of a Time or Duration message from nanoseconds.

    Raises:
        ValueError: The seconds do not fit into 32 bits.
    """
    stamp.sec, stamp.nanosec = divmod(nanoseconds, NANOSECONDS_PER_SECOND)


def split(nanoseconds: int) -> tuple[int, int]:
    """Return nanoseconds as a pair: seconds, rounded down, and the remaining nanoseconds."""
    return divmod(nanoseconds, NANOSECONDS_PER_SECOND)


def from_seconds(seconds: float) -> int:
    """Return a number of seconds in nanoseconds, truncated as in rclpy."""
    return int(seconds * NANOSECONDS_PER_SECOND)


def to_seconds(nanoseconds: int) -> float:
    """Return a number of nanoseconds in seconds, as float."""
    return nanoseconds / NANOSECONDS_PER_SECOND

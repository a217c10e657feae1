"""Times and durations in integer nanoseconds, as in ``rclpy.time`` and ``rclpy.duration``."""

from __future__ import annotations

import enum
import math

from teleopctl.base.typed import TYPE_CHECKING, overload
from teleopctl.interfaces import Stamp, from_seconds, get_message, split, to_nanoseconds, to_seconds

if TYPE_CHECKING:
    from builtin_interfaces.msg import Duration as DurationMessage, Time as TimeMessage

_INFINITE_NS = 2**63 - 1


class ClockType(enum.IntEnum):
    """Types of clocks and their times; times of different types cannot be compared."""

    UNINITIALIZED = 0
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3


class Duration:
    """Signed duration in nanoseconds.

    Args:
        seconds: Seconds, added to ``nanoseconds``.
        nanoseconds: Nanoseconds.

    Raises:
        OverflowError: The sum does not fit 64 bits.
    """

    __slots__ = ("nanoseconds",)

    def __init__(self, *, seconds: float = 0, nanoseconds: int = 0) -> None:
        total = from_seconds(seconds) + int(nanoseconds)
        if not -(2**63) <= total < 2**63:
            raise OverflowError("Total nanoseconds value is too large to store in C duration.")
        self.nanoseconds = total

    def get_c_duration(self) -> Duration:
        """Return the duration itself: it has the one attribute of rclpy's C object."""
        return self

    @property
    def seconds(self) -> float:
        """Duration in seconds (ours)."""
        return to_seconds(self.nanoseconds)

    def to_msg(self) -> DurationMessage:
        """Return the duration as a ``builtin_interfaces/msg/Duration``."""
        sec, nanosec = split(self.nanoseconds)
        message: type[DurationMessage] = get_message("builtin_interfaces/msg/Duration")
        return message(sec=sec, nanosec=nanosec)

    @classmethod
    def from_msg(cls, msg: Stamp) -> Duration:
        """Return the duration that a ``builtin_interfaces/msg/Duration`` holds."""
        return cls(nanoseconds=to_nanoseconds(msg))

    def __repr__(self) -> str:
        return f"Duration(nanoseconds={self.nanoseconds})"

    def __str__(self) -> str:
        return "Infinite" if self.nanoseconds == _INFINITE_NS else f"{self.nanoseconds} nanoseconds"

    def __hash__(self) -> int:
        return hash(self.nanoseconds)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Duration):
            return NotImplemented
        return self.nanoseconds == other.nanoseconds

    def __lt__(self, other: Duration) -> bool:
        if not isinstance(other, Duration):
            return NotImplemented
        return self.nanoseconds < other.nanoseconds

    def __le__(self, other: Duration) -> bool:
        if not isinstance(other, Duration):
            return NotImplemented
        return self.nanoseconds <= other.nanoseconds

    def __gt__(self, other: Duration) -> bool:
        if not isinstance(other, Duration):
            return NotImplemented
        return self.nanoseconds > other.nanoseconds

    def __ge__(self, other: Duration) -> bool:
        if not isinstance(other, Duration):
            return NotImplemented
        return self.nanoseconds >= other.nanoseconds

    def __neg__(self) -> Duration:
        return Duration(nanoseconds=-self.nanoseconds)

    def __add__(self, other: Duration) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return Duration(nanoseconds=self.nanoseconds + other.nanoseconds)

    def __sub__(self, other: Duration) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return Duration(nanoseconds=self.nanoseconds - other.nanoseconds)

    def __mul__(self, factor: float) -> Duration:
        product = self.nanoseconds * factor
        return Infinite if product == math.inf else Duration(nanoseconds=int(product))


Infinite = Duration(nanoseconds=_INFINITE_NS)


class Time:
    """Point in time on a clock of one type.

    Args:
        seconds: Seconds since the clock's epoch, added to ``nanoseconds``; not negative.
        nanoseconds: Nanoseconds since the clock's epoch; not negative.
        clock_type: Type of the clock.

    Raises:
        TypeError: ``clock_type`` is not a `ClockType`.
        ValueError: ``seconds`` or ``nanoseconds`` is negative.
        OverflowError: The sum does not fit 64 bits.
    """

    __slots__ = ("_clock_type", "nanoseconds")

    def __init__(
        self,
        *,
        seconds: float = 0,
        nanoseconds: int = 0,
        clock_type: ClockType = ClockType.SYSTEM_TIME,
    ) -> None:
        if not isinstance(clock_type, ClockType):
            raise TypeError(f"clock_type must be a ClockType, got {clock_type!r}")
        if seconds < 0:
            raise ValueError("Seconds value must not be negative")
        if nanoseconds < 0:
            raise ValueError("Nanoseconds value must not be negative")
        total = from_seconds(seconds) + int(nanoseconds)
        if total >= 2**63:
            raise OverflowError("Total nanoseconds value is too large to store in C time point.")
        self.nanoseconds = total
        self._clock_type = clock_type

    @property
    def clock_type(self) -> ClockType:
        """Type of the clock that the time belongs to."""
        return self._clock_type

    def seconds_nanoseconds(self) -> tuple[int, int]:
        """Return the time as whole seconds and remaining nanoseconds."""
        return split(self.nanoseconds)

    def to_msg(self) -> TimeMessage:
        """Return the time as a ``builtin_interfaces/msg/Time``."""
        sec, nanosec = split(self.nanoseconds)
        message: type[TimeMessage] = get_message("builtin_interfaces/msg/Time")
        return message(sec=sec, nanosec=nanosec)

    @classmethod
    def from_msg(cls, msg: Stamp, clock_type: ClockType = ClockType.ROS_TIME) -> Time:
        """Return the time that a ``builtin_interfaces/msg/Time`` holds, on a clock of a type."""
        return cls(nanoseconds=to_nanoseconds(msg), clock_type=clock_type)

    def _comparable(self, other: object) -> int:
        if not isinstance(other, Time):
            raise TypeError(f"cannot compare a Time with {type(other).__name__}")
        if self._clock_type != other.clock_type:
            raise TypeError("Can't compare times with different clock types")
        return other.nanoseconds

    def __repr__(self) -> str:
        return f"Time(nanoseconds={self.nanoseconds}, clock_type={self._clock_type.name})"

    def __hash__(self) -> int:
        return hash((self.nanoseconds, self._clock_type))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Time):
            return NotImplemented
        return self.nanoseconds == self._comparable(other)

    def __lt__(self, other: Time) -> bool:
        return self.nanoseconds < self._comparable(other)

    def __le__(self, other: Time) -> bool:
        return self.nanoseconds <= self._comparable(other)

    def __gt__(self, other: Time) -> bool:
        return self.nanoseconds > self._comparable(other)

    def __ge__(self, other: Time) -> bool:
        return self.nanoseconds >= self._comparable(other)

    def __add__(self, other: Duration) -> Time:
        if not isinstance(other, Duration):
            return NotImplemented
        return Time(nanoseconds=self.nanoseconds + other.nanoseconds, clock_type=self._clock_type)

    __radd__ = __add__

    @overload
    def __sub__(self, other: Time) -> Duration: ...

    @overload
    def __sub__(self, other: Duration) -> Time: ...

    def __sub__(self, other: Time | Duration) -> Time | Duration:
        if isinstance(other, Time):
            if self._clock_type != other._clock_type:
                raise TypeError("Can't subtract times with different clock types")
            return Duration(nanoseconds=self.nanoseconds - other.nanoseconds)
        if isinstance(other, Duration):
            return Time(
                nanoseconds=self.nanoseconds - other.nanoseconds, clock_type=self._clock_type
            )
        return NotImplemented

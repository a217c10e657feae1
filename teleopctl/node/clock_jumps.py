"""Jumps of a clock, and callbacks that are called for them, with the names of ``rclpy.clock``."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

from teleopctl.base.typed import Protocol
from teleopctl.node.values.time import Duration


class ClockChange(IntEnum):
    """Change of a clock's time source at a jump; numbers as in rcl."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class JumpThreshold:
    """Smallest size of a time jump for which callbacks are called.

    Args:
        min_forward: A positive duration; None for no jump forwards.
        min_backward: A negative duration; None for no jump backwards.
        on_clock_change: Whether the beginning and the end of simulated time are told.

    Raises:
        ValueError: A duration has the wrong sign, or nothing at all would be told.
    """

    def __init__(
        self,
        *,
        min_forward: Duration | None,
        min_backward: Duration | None,
        on_clock_change: bool = True,
    ) -> None:
        if min_forward is not None and min_forward.nanoseconds <= 0:
            raise ValueError("min_forward must be a positive non-zero duration")
        if min_backward is not None and min_backward.nanoseconds >= 0:
            raise ValueError("min_backward must be a negative non-zero duration")
        if min_forward is None and min_backward is None and not on_clock_change:
            raise ValueError("At least one jump threshold must be enabled")
        self.min_forward = min_forward
        self.min_backward = min_backward
        self.on_clock_change = on_clock_change

    def is_exceeded_by(self, jump: TimeJump) -> bool:
        """Return whether a time jump exceeds the threshold (ours)."""
        if jump.clock_change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            return self.on_clock_change
        if jump.delta.nanoseconds < 0:
            return self.min_backward is not None and jump.delta <= self.min_backward
        return self.min_forward is not None and jump.delta >= self.min_forward


class TimeJump:
    """A time jump of a clock.

    Args:
        clock_change: What it changed.
        delta: How far the clock went.

    Raises:
        TypeError: ``clock_change`` is no `ClockChange`.
    """

    def __init__(self, clock_change: ClockChange, delta: Duration) -> None:
        if not isinstance(clock_change, ClockChange):
            raise TypeError("clock_change must be an instance of rclpy.clock.ClockChange")
        self._clock_change = clock_change
        self._delta = delta

    @property
    def clock_change(self) -> ClockChange:
        """Change of the time source that the jump belongs to."""
        return self._clock_change

    @property
    def delta(self) -> Duration:
        """Difference between the times after and before the jump."""
        return self._delta


class Jumping(Protocol):
    """Interface of clocks that call jump handles."""

    def add_jump_handle(self, handle: JumpHandle) -> None:
        """Register a jump handle."""

    def remove_jump_handle(self, handle: JumpHandle) -> None:
        """Unregister a jump handle."""


class JumpHandle:
    """Callbacks for the jumps of a clock, until `unregister`; made by `create_jump_callback`.

    Args:
        clock: The clock.
        threshold: Which jumps are told.
        pre_callback: Called without arguments before the clock shows the new time.
        post_callback: Called with the `TimeJump` when it does.

    Raises:
        ValueError: There is no callback, or one cannot be called.
    """

    def __init__(
        self,
        *,
        clock: Jumping,
        threshold: JumpThreshold,
        pre_callback: Callable[[], object] | None,
        post_callback: Callable[[TimeJump], object] | None,
    ) -> None:
        if pre_callback is None and post_callback is None:
            raise ValueError("One of pre_callback or post_callback must be callable")
        for name, callback in (("pre_callback", pre_callback), ("post_callback", post_callback)):
            if callback is not None and not callable(callback):
                raise ValueError(f"{name} must be callable if given")
        self._clock: Jumping | None = clock
        self._threshold = threshold
        self._pre_callback = pre_callback
        self._post_callback = post_callback
        clock.add_jump_handle(self)

    def unregister(self) -> None:
        """Stop calling the callbacks. Idempotent."""
        clock, self._clock = self._clock, None
        if clock is not None:
            clock.remove_jump_handle(self)

    def begin(self, jump: TimeJump) -> None:
        """Call the pre-callback for a jump that is about to happen (ours)."""
        if self._pre_callback is not None and self._threshold.is_exceeded_by(jump):
            self._pre_callback()

    def end(self, jump: TimeJump) -> None:
        """Call the post-callback for a jump that has happened (ours)."""
        if self._post_callback is not None and self._threshold.is_exceeded_by(jump):
            self._post_callback(jump)

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(self, *_: object) -> None:
        self.unregister()

"""Clocks (system, steady and ROS time) and callbacks for their time jumps."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from enum import IntEnum

from teleopctl.base.typed import Protocol
from teleopctl.interfaces import to_seconds
from teleopctl.node.context import Context
from teleopctl.node.values.handle import Handle
from teleopctl.node.values.time import ClockType, Duration, Time


class ClockChange(IntEnum):
    """Change of a clock's time source at a time jump, numbered as in rcl."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class JumpThreshold:
    """Thresholds that a time jump must reach for jump callbacks to be called.

    Args:
        min_forward: Smallest jump forwards, positive; None ignores jumps forwards.
        min_backward: Smallest jump backwards, negative; None ignores jumps backwards.
        on_clock_change: Whether switching simulated time on or off counts as a jump.

    Raises:
        ValueError: A duration has the wrong sign, or no kind of jump is enabled.
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
        """Return whether a time jump reaches the threshold for its kind of jump (ours)."""
        if jump.clock_change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            return self.on_clock_change
        if jump.delta.nanoseconds < 0:
            return self.min_backward is not None and jump.delta <= self.min_backward
        return self.min_forward is not None and jump.delta >= self.min_forward


class TimeJump:
    """Size and cause of a time jump, as jump callbacks receive it.

    Args:
        clock_change: Change of the clock's time source.
        delta: Time difference of the jump, negative for a jump back.

    Raises:
        TypeError: ``clock_change`` is not a `ClockChange`.
    """

    def __init__(self, clock_change: ClockChange, delta: Duration) -> None:
        if not isinstance(clock_change, ClockChange):
            raise TypeError("clock_change must be an instance of rclpy.clock.ClockChange")
        self._clock_change = clock_change
        self._delta = delta

    @property
    def clock_change(self) -> ClockChange:
        """Change of the clock's time source at the jump; a value NO_CHANGE if there was none."""
        return self._clock_change

    @property
    def delta(self) -> Duration:
        """Clock time after the jump minus that before; 0 at a change of the time source."""
        return self._delta


class JumpingClock(Protocol):
    """Interface of a clock as `JumpHandle` uses it."""

    def add_jump_handle(self, handle: JumpHandle) -> None:
        """Register a jump handle, whose `begin` and `end` are called at each time jump."""

    def remove_jump_handle(self, handle: JumpHandle) -> None:
        """Unregister a jump handle."""


class JumpHandle:
    """Registered jump callbacks of a clock, until `unregister`; made by `create_jump_callback`.

    Args:
        clock: Clock of the jumps.
        threshold: Smallest jumps for which the callbacks are called.
        pre_callback: Called without arguments before the clock is set.
        post_callback: Called with the `TimeJump` after the clock was set.

    Raises:
        ValueError: Both callbacks are None, or one is not callable.
    """

    def __init__(
        self,
        *,
        clock: JumpingClock,
        threshold: JumpThreshold,
        pre_callback: Callable[[], object] | None,
        post_callback: Callable[[TimeJump], object] | None,
    ) -> None:
        if pre_callback is None and post_callback is None:
            raise ValueError("One of pre_callback or post_callback must be callable")
        for name, callback in (("pre_callback", pre_callback), ("post_callback", post_callback)):
            if callback is not None and not callable(callback):
                raise ValueError(f"{name} must be callable if given")
        self._clock: JumpingClock | None = clock
        self._threshold = threshold
        self._pre_callback = pre_callback
        self._post_callback = post_callback
        clock.add_jump_handle(self)

    def unregister(self) -> None:
        """Unregister the callbacks from the clock. Idempotent."""
        clock, self._clock = self._clock, None
        if clock is not None:
            clock.remove_jump_handle(self)

    def begin(self, jump: TimeJump) -> None:
        """Call the pre-callback, if any, before a jump that reaches the threshold (ours)."""
        if self._pre_callback is not None and self._threshold.is_exceeded_by(jump):
            self._pre_callback()

    def end(self, jump: TimeJump) -> None:
        """Call the post-callback, if any, after a jump that reached the threshold (ours)."""
        if self._post_callback is not None and self._threshold.is_exceeded_by(jump):
            self._post_callback(jump)

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(self, *_: object) -> None:
        self.unregister()


class Clock:
    """Clock of a given type: system, steady or ROS time.

    ``Clock(clock_type=ClockType.ROS_TIME)`` is a `ROSClock`, as in rclpy.
    """

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Clock:
        """Create a clock of the class for a clock type."""
        return super().__new__(ROSClock if clock_type == ClockType.ROS_TIME else cls)

    def __init__(self, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> None:
        if not isinstance(clock_type, ClockType):
            raise TypeError(f"clock_type must be a ClockType, not {type(clock_type).__name__}")
        self._clock_type = clock_type
        # Replaced, never changed, so that a jump may iterate without a lock.
        self._jump_handles: tuple[JumpHandle, ...] = ()
        # Called when simulated time is switched on or off, which only a `ROSClock` does.
        self._on_switch: list[Callable[[], None]] = []

    def __repr__(self) -> str:
        return f"{type(self).__name__}(clock_type={self._clock_type.name})"

    @property
    def handle(self) -> Handle:
        """Handle of the clock, as in rclpy."""
        return Handle(self)

    @property
    def is_destroyed(self) -> bool:
        """Always False: clocks are never destroyed (ours)."""
        return False

    def destroy(self) -> None:
        """Do nothing: a clock holds no resources (ours)."""

    @property
    def clock_type(self) -> ClockType:
        """Type of the clock: system, steady or ROS time."""
        return self._clock_type

    def nanoseconds(self) -> int:
        """Return the clock's present time in nanoseconds, without creating a `Time` (ours)."""
        if self._clock_type == ClockType.STEADY_TIME:
            return time.monotonic_ns()
        return time.time_ns()

    def elapsed_ns(self) -> int:
        """Return the steady clock's nanoseconds, which jumps of this clock do not affect (ours).

        It is the steady clock's time: system time may be set, as NTP does on a machine that starts
        without a battery-backed clock. rcl measures periods by the clock's own time, so that after
        a jump back its timers stop until the clock has reached the former time again.
        """
        return time.monotonic_ns()

    def now(self) -> Time:
        """Return the clock's present time."""
        return Time(nanoseconds=self.nanoseconds(), clock_type=self._clock_type)

    def create_jump_callback(
        self,
        threshold: JumpThreshold,
        *,
        pre_callback: Callable[[], object] | None = None,
        post_callback: Callable[[TimeJump], object] | None = None,
    ) -> JumpHandle:
        """Register callbacks for time jumps, which only a `ROSClock` reports; return a handle.

        The callbacks run on the thread that sets the clock, a thread of Zenoh for ``/clock``: they
        should be quick.

        Args:
            threshold: Smallest jumps for which the callbacks are called.
            pre_callback: Called without arguments before the clock is set.
            post_callback: Called with the `TimeJump` after the clock was set.

        Raises:
            ValueError: Both callbacks are None, or one is not callable.
        """
        return JumpHandle(
            clock=self,
            threshold=threshold,
            pre_callback=pre_callback,
            post_callback=post_callback,
        )

    def add_jump_handle(self, handle: JumpHandle) -> None:
        """Register a jump handle (ours); handles call this when they are created."""
        self._jump_handles = (*self._jump_handles, handle)

    def remove_jump_handle(self, handle: JumpHandle) -> None:
        """Unregister a jump handle (ours); unknown ones are ignored."""
        self._jump_handles = tuple(other for other in self._jump_handles if other is not handle)

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Sleep until the clock reaches a time; False on shutdown or a change of time source.

        Raises:
            NotInitializedException: The context is not running.
            ValueError: The time has another clock type.
        """
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        return self._sleep(self.nanoseconds, until.nanoseconds, context)

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a duration by the clock; False on shutdown or a change of time source.

        Args:
            rel_time: Duration of the sleep.
            context: Context whose shutdown ends the sleep; the default context if None.

        Raises:
            NotInitializedException: The context is not running.
        """
        return self._sleep(self.elapsed_ns, self.elapsed_ns() + rel_time.nanoseconds, context)

    def _sleep(self, count_ns: Callable[[], int], end_ns: int, context: Context | None) -> bool:
        """Sleep until a count of this clock reaches its end."""
        owner = context or Context.default()
        if not owner.ok():
            raise owner.not_running_error()
        wake = threading.Event()
        owner.on_shutdown(wake.set)
        self._on_switch.append(wake.set)
        try:
            reached = owner.ok() and self._wait_until(count_ns, end_ns, wake)
            return reached and not wake.is_set()
        finally:
            self._on_switch.remove(wake.set)
            owner.forget_on_shutdown(wake.set)

    def _wait_until(self, count_ns: Callable[[], int], end_ns: int, wake: threading.Event) -> bool:
        """Wait until a count reaches its end; return False if an event is set before."""
        while (left_ns := end_ns - count_ns()) > 0:
            if wake.wait(to_seconds(left_ns)):
                return False
        return True


class ROSClock(Clock):
    """ROS time: the system time, or simulated time while ``use_sim_time`` is true.

    Before the first message of ``/clock`` simulated time is 0, as in ROS 2.

    Attributes:
        before_reading: Called before the simulated time is read, to set it; None if it is set with
            each message (ours).
    """

    def __new__(cls) -> ROSClock:
        """Create the clock, without a choice of its type."""
        return object.__new__(cls)

    def __init__(self, *, clock_type: ClockType = ClockType.ROS_TIME) -> None:
        super().__init__(clock_type=clock_type)
        self._simulated_ns = 0
        self.before_reading: Callable[[], None] | None = None
        # Whether time is simulated, and the offset of its count, which keeps `elapsed_ns`
        # continuous when simulated time is switched on or off. One tuple, for an atomic change.
        self._source: tuple[bool, int] = (False, 0)
        self._moved = threading.Condition()
        self._listeners: list[Callable[[], None]] = []

    @property
    def ros_time_is_active(self) -> bool:
        """Whether simulated time is active."""
        return self._source[0]

    def nanoseconds(self) -> int:
        """Return the present time in nanoseconds: simulated if active, else the system's."""
        if not self._source[0]:
            return time.time_ns()
        if self.before_reading is not None:
            self.before_reading()
        return self._simulated_ns

    def elapsed_ns(self) -> int:
        """Return a count of simulated or steady nanoseconds, continuous at a source change (ours).

        It counts simulated time while that is active, else the steady clock. It is continuous when
        the source changes, so that a running period keeps its remaining time, as in rcl.
        """
        simulated, offset_ns = self._source
        return offset_ns + (self._simulated_ns if simulated else time.monotonic_ns())

    def set_simulated(self, active: bool) -> None:
        """Switch to simulated or system time; a change calls jump callbacks and ends sleeps."""
        switches = active != self.ros_time_is_active
        if switches and self._jump_handles:
            change = ClockChange.ROS_TIME_ACTIVATED if active else ClockChange.ROS_TIME_DEACTIVATED
            self._jump(change, 0, lambda: self._switch(active))
        elif switches:
            self._switch(active)
        for listener in tuple(self._on_switch) if switches else ():
            listener()
        self._notify_waiting()

    def _switch(self, active: bool) -> None:
        count_ns = self._simulated_ns if active else time.monotonic_ns()
        self._source = (active, self.elapsed_ns() - count_ns)

    def set_simulated_time(self, nanoseconds: int) -> None:
        """Set the simulated time, active or not, in nanoseconds; called for ``/clock`` messages."""
        if self.ros_time_is_active and self._jump_handles:
            step = nanoseconds - self._simulated_ns
            change = ClockChange.ROS_TIME_NO_CHANGE
            self._jump(change, step, lambda: setattr(self, "_simulated_ns", nanoseconds))
        else:
            self._simulated_ns = nanoseconds
        self._notify_waiting()

    def set_ros_time_override(self, time: Time) -> None:
        """Set the time that the clock shows while simulated time is active, as rclpy.

        Raises:
            TypeError: ``time`` is not a `Time`.
        """
        if not isinstance(time, Time):
            raise TypeError(
                f"Time must be specified as rclpy.time.Time. Received type: {type(time)}"
            )
        self.set_simulated_time(time.nanoseconds)

    def _set_ros_time_is_active(self, enabled: bool) -> None:
        self.set_simulated(enabled)  # rclpy's tests and time sources use that name

    def _jump(self, change: ClockChange, step_ns: int, move: Callable[[], None]) -> None:
        jump = TimeJump(change, Duration(nanoseconds=step_ns))
        handles = self._jump_handles
        for handle in handles:
            handle.begin(jump)
        move()
        for handle in handles:
            handle.end(jump)

    def on_time_update(self, listener: Callable[[], None]) -> None:
        """Register a function to call whenever simulated time or the time source is set."""
        self._listeners.append(listener)

    def forget_on_time_update(self, listener: Callable[[], None]) -> None:
        """Unregister a function of `on_time_update`; unknown ones are ignored."""
        if listener in self._listeners:
            self._listeners.remove(listener)

    def _notify_waiting(self) -> None:
        with self._moved:
            self._moved.notify_all()
        for listener in tuple(self._listeners):
            listener()

    def _wait_until(self, count_ns: Callable[[], int], end_ns: int, wake: threading.Event) -> bool:
        """Wait by simulated time if it is active."""
        if not self.ros_time_is_active:
            return super()._wait_until(count_ns, end_ns, wake)
        with self._moved:
            while count_ns() < end_ns:
                if wake.is_set():
                    return False
                # A thread that does not set the clock may set the event, hence the timeout.
                self._moved.wait(0.1)
        return True

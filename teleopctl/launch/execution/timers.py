"""What a launch waits for beside its processes: timers, and work that goes on."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from functools import partial

from teleopctl.errors import TeleopctlError
from teleopctl.launch.asking.asking import CallSequence
from teleopctl.launch.execution.event_loop import EventLoop
from teleopctl.launch.execution.published_status import PublishedStatus
from teleopctl.launch.model.plan import LaunchTimer, Work

# A timer that takes longer keeps nobody waiting for the launch to be up.
_SOON_S = 30.0


class Timers:
    """Pending timers and service calls of a launch.

    Args:
        loop: Where their ends are told.
        published: Is told when work begins or ends.
        fire: Called with a timer whose time has come.
        ended: Called when work has ended, with an error where it failed.
    """

    def __init__(
        self,
        loop: EventLoop,
        published: PublishedStatus,
        fire: Callable[[LaunchTimer], None],
        ended: Callable[[TeleopctlError | None], None],
    ) -> None:
        self._loop = loop
        self._published = published
        self._fire = fire
        self._ended = ended
        self._numbers = itertools.count()
        # When what waits for a timer is to come, in monotonic seconds.
        self._due: dict[int, tuple[float, LaunchTimer]] = {}
        self._works = 0
        self._asking = 0

    def __bool__(self) -> bool:
        """Whether there is something to wait for."""
        self._forget(lambda timer: timer.is_cancelled())
        return bool(self._due or self._works)

    def pending(self) -> int:
        """Return the number of timers that are due soon and of pending service calls.

        Any thread may ask.
        """
        soon = time.monotonic() + _SOON_S
        return self._asking + sum(due <= soon for due, _ in tuple(self._due.values()))

    def add(self, seconds: float, timer: LaunchTimer) -> None:
        """Start a timer."""
        number = next(self._numbers)
        self._due[number] = (time.monotonic() + seconds, timer)
        self._loop.after(seconds, partial(self._time_has_come, number))

    def begin(self, work: Work) -> None:
        """Start work, and wait for its end."""
        self._works += 1
        self._asking += isinstance(work, CallSequence)
        work.begin(lambda error: self._loop.put(partial(self._has_ended, work, error)))
        self._published.publish()

    def shut_down(self) -> None:
        """Cancel all timers that the shutdown does not wait for."""
        self._forget(lambda timer: not timer.outlives_shutdown)

    def _forget(self, is_forgotten: Callable[[LaunchTimer], bool]) -> None:
        self._due = {
            number: entry for number, entry in self._due.items() if not is_forgotten(entry[1])
        }

    def _time_has_come(self, number: int) -> None:
        entry = self._due.pop(number, None)
        if entry is not None:
            self._fire(entry[1])

    def _has_ended(self, work: Work, error: TeleopctlError | None) -> None:
        self._works -= 1
        self._asking -= isinstance(work, CallSequence)
        self._published.publish()
        self._ended(error)

"""Watchdog of the control cycle: names what keeps cycles from running."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.control.cycle import Cycle
from teleopctl.errors import DefectError, TeleopctlError

if TYPE_CHECKING:
    from teleopctl.node import RcutilsLogger

DEFAULT_LIMIT_S = 10.0
"""Default of the parameter ``cycle_timeout``, in seconds."""

_LOOK_EVERY_S = 0.5
_ABORTED = "Goals are aborted, and goals and commands are refused"
# A cycle that takes longer is reported.
_PATIENCE_S = 1.0


class CycleWatchdog:
    """Thread that reports a control cycle that does not end, and missing states.

    Python cannot interrupt a controller that waits for something or loops without end: after a
    limit the watchdog calls a function.

    Args:
        cycle: Control cycle to watch.
        logger: Logger of the reports.
        limit_s: Duration of a cycle after which ``on_limit`` is called, in seconds; 0 for never.
        on_limit: Called once with the error.
        aborts_goals: Whether a cycle that does not end aborts goals, as the robot does not wait.

    Attributes:
        absence: Function that returns why no states come that trigger cycles; empty if they may.
    """

    def __init__(
        self,
        cycle: Cycle,
        logger: RcutilsLogger,
        *,
        limit_s: float,
        on_limit: Callable[[TeleopctlError], object],
        aborts_goals: bool = False,
    ) -> None:
        self._cycle = cycle
        self._logger = logger
        self._limit_s = limit_s
        self._on_limit = on_limit
        self._aborts_goals = aborts_goals
        self.absence: Callable[[], str] = lambda: ""
        self._absence = ""
        self._reported_s = 0.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="cycle watchdog", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread at its next look."""
        self._stop.set()

    def _run(self) -> None:
        while not self._stop.wait(_LOOK_EVERY_S):
            if self.look():
                return

    def look(self) -> bool:
        """Check the cycle once, as the thread does; return whether the limit was reached."""
        began_s, (name, function) = self._cycle.began_s, self._cycle.what_runs()
        took_s = time.monotonic() - began_s
        if began_s == 0.0:
            self._check_states()
            return False
        if took_s < _PATIENCE_S:
            return False
        reason = f"{name} has not returned from {function}() for {took_s:.1f} s"
        if began_s != self._reported_s:
            self._reported_s = began_s
            if self._aborts_goals:
                self._cycle.stand_still(reason)
            self._logger.error(
                f"{reason}: the control cycle stands still"
                + (f". {_ABORTED}" if self._aborts_goals else "")
            )
        if not 0.0 < self._limit_s <= took_s:
            return False
        self._on_limit(
            DefectError(
                reason,
                hint="Methods of the control cycle must not wait. The parameter `cycle_timeout` of "
                "the controller manager sets the limit (0: none); with `control:=topic` the "
                "simulator outlives its controllers.",
            )
        )
        return True

    def _check_states(self) -> None:
        """Report once that no more states arrive, and abort the goals."""
        before, self._absence = self._absence, self.absence()
        if self._absence and not before:
            self._cycle.stand_still(self._absence)
            self._logger.error(
                f"{self._absence}: the control cycle stands still. {_ABORTED}, until states come "
                "again"
            )

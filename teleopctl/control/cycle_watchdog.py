"""Watchdog of the control cycle: names the controller or hardware that does not return."""

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
# A cycle that takes longer is reported.
_PATIENCE_S = 1.0


class CycleWatchdog:
    """Thread that reports a control cycle that does not end, and calls a function after a limit.

    Python cannot interrupt a controller that waits for something or loops without end.

    Args:
        cycle: Control cycle to watch.
        logger: Logger of the reports.
        limit_s: Duration of a cycle after which ``on_limit`` is called, in seconds; 0 for never.
        on_limit: Called once with the error.
    """

    def __init__(
        self,
        cycle: Cycle,
        logger: RcutilsLogger,
        *,
        limit_s: float,
        on_limit: Callable[[TeleopctlError], object],
    ) -> None:
        self._cycle = cycle
        self._logger = logger
        self._limit_s = limit_s
        self._on_limit = on_limit
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
            began_s, (name, function) = self._cycle.began_s, self._cycle.what_runs()
            took_s = time.monotonic() - began_s
            if began_s == 0.0 or took_s < _PATIENCE_S:
                continue
            if began_s != self._reported_s:
                self._reported_s = began_s
                self._logger.error(
                    f"{name} has not returned from {function}() for {took_s:.1f} s: the control "
                    "cycle stands still"
                )
            if 0.0 < self._limit_s <= took_s:
                self._on_limit(
                    DefectError(
                        f"{name} has not returned from {function}() for {took_s:.1f} s",
                        hint="Methods of the control cycle must not wait. The parameter "
                        "`cycle_timeout` of the controller manager sets the limit (0: none); with "
                        "`control:=topic` the simulator outlives its controllers.",
                    )
                )
                return

"""Timeouts of starting processes, which depend on their progress.

A process may take seconds or minutes to start, depending on its robot and the machine, so that no
fixed time distinguishes a slow start from one that hangs. Progress does: reports, output, and the
processor time that a process uses. A deadlock shows none of these and fails after a short time; an
endless loop uses processor time and fails after a long time.
"""

from __future__ import annotations

import contextlib
import time

from teleopctl.base.typed import Callable, Iterable, NamedTuple

# Share of one core above which a process counts as busy. A waiting node uses a thousandth
# (measured: a subscription 0.05 %, a spawner without a controller manager 0.2 %); a busy node uses
# more than this share even on an overloaded machine.
_WORKING_SHARE = 0.02
# Searching all processes of the system for descendants takes a few milliseconds.
_SAMPLE_EVERY_S = 1.0


class StartTimeouts(NamedTuple):
    """Time limits for starting background processes: in all, and without any progress.

    Attributes:
        stall_s: Longest time without any progress, in seconds.
        total_s: Longest time in all, in seconds.
    """

    stall_s: float = 30.0
    total_s: float = 300.0


class ProgressMonitor:
    """Measures the time without progress and the total time of a start.

    Args:
        timeouts: Time limits of the start.
        now: Returns the time of a steady clock, in seconds.
    """

    def __init__(self, timeouts: StartTimeouts, now: Callable[[], float] = time.monotonic) -> None:
        self._timeouts = timeouts
        self._now = now
        self._began = self._progressed = now()
        self._sampled = -_SAMPLE_EVERY_S
        self._signs: object = None
        # Processor time of each process at the last sample, and their increase since progress.
        self._used_s: dict[int, float] = {}
        self._worked_s = 0.0

    @property
    def elapsed_s(self) -> float:
        """Seconds since this monitor was created, at the start of the processes."""
        return self._now() - self._began

    @property
    def has_stalled(self) -> bool:
        """Whether the time without progress has reached its limit."""
        return self._now() - self._progressed >= self._timeouts.stall_s

    @property
    def is_over(self) -> bool:
        """Whether the total time of the start has reached its limit."""
        return self.elapsed_s >= self._timeouts.total_s

    def update(self, signs: object, pids: Iterable[int]) -> None:
        """Compare signs and processor times with the last ones; reset the stall time on progress.

        Args:
            signs: Reports and output so far; a difference from the last call is progress.
            pids: PIDs of the starting processes. Their processor time and that of their descendants
                is measured.
        """
        now = self._now()
        if signs != self._signs:
            self._signs = signs
            self._note_progress(now)
        # Processor times take long to read: only while nothing else shows progress.
        quiet_s = now - max(self._sampled, self._progressed)
        if quiet_s < min(_SAMPLE_EVERY_S, self._timeouts.stall_s / 4):
            return
        self._sampled = now
        used_s = processor_times(pids)
        self._worked_s += sum(
            max(0.0, time_s - self._used_s.get(pid, 0.0)) for pid, time_s in used_s.items()
        )
        self._used_s = used_s
        if self._worked_s > _WORKING_SHARE * self._timeouts.stall_s:
            self._note_progress(now)

    def _note_progress(self, now: float) -> None:
        self._progressed = now
        self._worked_s = 0.0


def processor_times(pids: Iterable[int]) -> dict[int, float]:
    """Return the processor time in seconds of running processes and their descendants, by PID."""
    import psutil

    children: dict[int, list[psutil.Process]] = {}
    processes: dict[int, psutil.Process] = {}
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            children.setdefault(process.ppid(), []).append(process)
            processes[process.pid] = process
    found: dict[int, float] = {}
    left = [processes[pid] for pid in pids if pid in processes]
    while left:
        process = left.pop()
        left += children.get(process.pid, ())
        with contextlib.suppress(psutil.Error):  # the process has ended
            times = process.cpu_times()
            found[process.pid] = times.user + times.system
    return found

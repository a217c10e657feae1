"""Events of a launch: of processes, shutdown and signals."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass

from teleopctl.launch.model.descriptions import ProcessPart
from teleopctl.launch.model.plan import ProcessPlan


@dataclass(frozen=True, slots=True)
class ProcessEvent:
    """Base of the events of one process of a launch.

    Attributes:
        plan: What was started.
        pid: Its process id.
    """

    plan: ProcessPlan
    pid: int


@dataclass(frozen=True, slots=True)
class ProcessStarted(ProcessEvent):
    """Event: a process was started.

    Attributes:
        was_saved: Whether it was started again because its source had been saved, which no handler
            answers.
    """

    was_saved: bool = False


@dataclass(frozen=True, slots=True)
class ProcessExited(ProcessEvent):
    """Event: a process has ended, and all of its output was read.

    Attributes:
        exit_status: What it ended with; negative for a signal.
    """

    exit_status: int


@dataclass(frozen=True, slots=True)
class ProcessOutput(ProcessEvent):
    """Event: a process has written a line to stdout or stderr.

    Attributes:
        text: A line with its ending, as it came.
        from_stdout: Whether it came from stdout, and not from stderr.
    """

    text: bytes
    from_stdout: bool


@dataclass(frozen=True, slots=True)
class ShutdownBegan:
    """Event: the shutdown of the launch has begun.

    Attributes:
        reason: Why.
        by_interrupt: Whether a person pressed Ctrl-C.
    """

    reason: str
    by_interrupt: bool = False


@dataclass(frozen=True, slots=True)
class ShutdownRequested:
    """Event: another thread requests the shutdown of the launch.

    Attributes:
        reason: Why.
    """

    reason: str


@dataclass(frozen=True, slots=True)
class SignalRequested:
    """Event: a signal is requested for those processes that ``matches`` selects.

    Attributes:
        matches: Returns whether a process is to get the signal.
        number: The signal; None terminates the process as a shutdown does.
    """

    matches: Callable[[ProcessPart, ProcessPlan], bool]
    number: signal.Signals | None = None

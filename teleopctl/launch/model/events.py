"""Events of a launch: of processes, shutdown and signals."""

from __future__ import annotations

import signal

from teleopctl.base.typed import Callable
from teleopctl.launch.model.descriptions import ProcessPart
from teleopctl.launch.model.plan import ProcessPlan
from teleopctl.launch.model.records import dataclass


@dataclass(frozen=True, slots=True)
class ProcessEvent:
    """Base of the events of one process of a launch.

    Attributes:
        plan: Plan of the process.
        pid: Process id.
    """

    plan: ProcessPlan
    pid: int


@dataclass(frozen=True, slots=True)
class ProcessStarted(ProcessEvent):
    """Event: a process was started.

    Attributes:
        was_saved: Whether the process was restarted because its source was saved; event handlers
            are then not called.
    """

    was_saved: bool = False


@dataclass(frozen=True, slots=True)
class ProcessExited(ProcessEvent):
    """Event: a process has ended, and all of its output was read.

    Attributes:
        exit_status: Exit status of the process; negative for a signal.
    """

    exit_status: int


@dataclass(frozen=True, slots=True)
class ProcessOutput(ProcessEvent):
    """Event: a process has written a line to stdout or stderr.

    Attributes:
        text: Line of output with its ending, as written.
        from_stdout: Whether the line comes from stdout, not from stderr.
    """

    text: bytes
    from_stdout: bool


@dataclass(frozen=True, slots=True)
class ShutdownBegan:
    """Event: the shutdown of the launch has begun.

    Attributes:
        reason: Reason for the shutdown.
        by_interrupt: Whether Ctrl-C (SIGINT) caused the shutdown.
    """

    reason: str
    by_interrupt: bool = False


@dataclass(frozen=True, slots=True)
class ShutdownRequested:
    """Event: another thread requests the shutdown of the launch.

    Attributes:
        reason: Reason for the shutdown.
    """

    reason: str


@dataclass(frozen=True, slots=True)
class SignalRequested:
    """Event: a signal is requested for those processes that ``matches`` selects.

    Attributes:
        matches: Returns whether to signal a process, given its action and plan.
        number: Signal to send; None terminates the process as a shutdown does.
    """

    matches: Callable[[ProcessPart, ProcessPlan], bool]
    number: signal.Signals | None = None

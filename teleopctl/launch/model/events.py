"""What happens while a launch runs, as its handlers see it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass

from teleopctl.launch.model.descriptions import ProcessPart
from teleopctl.launch.model.plan import ProcessPlan


@dataclass(frozen=True, slots=True)
class ProcessEvent:
    """Base of events of a process.

    Attributes:
        plan: What was started.
        pid: Its process id.
    """

    plan: ProcessPlan
    pid: int


@dataclass(frozen=True, slots=True)
class ProcessStarted(ProcessEvent):
    """A process was started.

    Attributes:
        was_saved: Whether it was started again because its source had been saved, which no handler
            answers.
    """

    was_saved: bool = False


@dataclass(frozen=True, slots=True)
class ProcessExited(ProcessEvent):
    """A process has ended, and all of its output was handled.

    Attributes:
        exit_status: What it ended with; negative for a signal.
    """

    exit_status: int


@dataclass(frozen=True, slots=True)
class ProcessOutput(ProcessEvent):
    """A process has written output.

    Attributes:
        text: A line with its ending, as it came.
        from_stdout: Whether it came from stdout, and not from stderr.
    """

    text: bytes
    from_stdout: bool


@dataclass(frozen=True, slots=True)
class ShutdownBegan:
    """The shutdown of the launch has begun.

    Attributes:
        reason: Why.
        by_interrupt: Whether a person pressed Ctrl-C.
    """

    reason: str
    by_interrupt: bool = False


@dataclass(frozen=True, slots=True)
class ShutdownRequested:
    """A request, from outside the launch's steps, to end the launch.

    Attributes:
        reason: Why.
    """

    reason: str


@dataclass(frozen=True, slots=True)
class SignalRequested:
    """A request to send a signal to some of the processes.

    Attributes:
        matches: Tells of a process whether it is meant.
        number: The signal; None asks for the end as a shutdown does, by harder ways where needed.
    """

    matches: Callable[[ProcessPart, ProcessPlan], bool]
    number: signal.Signals | None = None

"""Events of the model as Python launch files know them, and the other way round."""

from __future__ import annotations

import os
from typing import Any, cast

from teleopctl import launch as model
from teleopctl.launch import Launch, Process, ProcessPlan

from ..action import Action
from ..event import Event
from .execution_complete import ExecutionComplete
from .include_launch_description import IncludeLaunchDescription
from .process import (
    ProcessExited,
    ProcessStarted,
    ProcessStderr,
    ProcessStdout,
    ProcessTargetedEvent,
    RunningProcessEvent,
    SignalProcess,
)
from .shutdown import Shutdown


def event_of(event: object, launch: Launch) -> Event:
    """Return what has happened as a Python launch file is told it."""
    match event:
        case model.ProcessStarted():
            return ProcessStarted(**_details(event, launch))
        case model.ProcessExited():
            return ProcessExited(returncode=event.exit_status, **_details(event, launch))
        case model.ProcessOutput():
            kind = ProcessStdout if event.from_stdout else ProcessStderr
            return kind(text=event.text, **_details(event, launch))
        case model.ShutdownBegan():
            return Shutdown(reason=event.reason, due_to_sigint=event.by_interrupt)
        case _:
            # A user's own, which need not be of that class.
            return cast(Event, event)


# Any: the words of RunningProcessEvent.
def _details(event: model.ProcessEvent, launch: Launch) -> dict[str, Any]:
    return details(launch.action_of(event.plan), event.plan, event.pid)


def details(process: Process, plan: ProcessPlan, pid: int) -> dict[str, Any]:
    """Return what is told of a process, by the words of `RunningProcessEvent`."""
    origin = process.origin
    return {
        "action": origin if isinstance(origin, Action) else Action(),
        "name": plan.name,
        "cmd": plan.command,
        "cwd": plan.working_directory,
        "env": environment_of(plan),
        "pid": pid,
    }


def environment_of(plan: ProcessPlan) -> dict[str, str]:
    """Return the whole environment that a process is started with."""
    whole = {**os.environ, **plan.environment}
    return {name: value for name, value in whole.items() if value is not None}


def emit(event: Event, launch: Launch) -> None:
    """Make an event of a Python launch file happen."""
    if isinstance(event, Shutdown):
        launch.shut_down(event.reason)
    elif isinstance(event, ProcessTargetedEvent):
        number = event.signal if isinstance(event, SignalProcess) else None
        matches = event.process_matcher

        def is_meant(process: Process, plan: ProcessPlan) -> bool:  # noqa: ARG001 -- ours know it
            return isinstance(process.origin, Action) and matches(process.origin)

        launch.emit(model.SignalRequested(is_meant, number))
    else:
        launch.emit(event)


__all__ = [
    "ExecutionComplete",
    "IncludeLaunchDescription",
    "RunningProcessEvent",
    "details",
    "emit",
    "event_of",
]

"""Conversion of events of `teleopctl.launch` to those of Python launch files."""

from __future__ import annotations

import os
from typing import Any

from teleopctl import launch as model
from teleopctl.launch import Launch, ProcessPart, ProcessPlan

from ..action import Action
from ..event import event_of
from .process import ProcessExited, ProcessStarted, ProcessStderr, ProcessStdout
from .shutdown import Shutdown


@event_of.register
def _(event: model.ProcessStarted, launch: Launch) -> ProcessStarted:
    return ProcessStarted(**_details(event, launch))


@event_of.register
def _(event: model.ProcessExited, launch: Launch) -> ProcessExited:
    return ProcessExited(returncode=event.exit_status, **_details(event, launch))


@event_of.register
def _(event: model.ProcessOutput, launch: Launch) -> ProcessStdout | ProcessStderr:
    kind = ProcessStdout if event.from_stdout else ProcessStderr
    return kind(text=event.text, **_details(event, launch))


@event_of.register
def _(event: model.ShutdownBegan, _launch: Launch) -> Shutdown:
    return Shutdown(reason=event.reason, due_to_sigint=event.by_interrupt)


# Any: arguments of `RunningProcessEvent.`
def _details(event: model.ProcessEvent, launch: Launch) -> dict[str, Any]:
    return details(launch.action_of(event.plan), event.plan, event.pid)


def details(process: ProcessPart, plan: ProcessPlan, pid: int) -> dict[str, Any]:
    """Return the constructor arguments of `RunningProcessEvent` for a process."""
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
    """Return the whole environment of a process."""
    whole = {**os.environ, **plan.environment}
    return {name: value for name, value in whole.items() if value is not None}

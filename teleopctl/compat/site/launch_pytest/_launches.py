"""Launches of pytest fixtures: settings, start and end."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

from launch import LaunchService

SCOPES = ("function", "class", "module", "package", "session")
"""Scopes of fixtures, the narrowest first."""


@dataclass(frozen=True, slots=True)
class LaunchFixture:
    """Settings of a fixture that returns a launch description.

    Attributes:
        name: The fixture's name.
        scope: The fixture's scope.
        shutdown_when_idle: Whether its launch ends when no process is left.
        auto_shutdown: Whether its launch is ended when the tests beside it have run.
    """

    name: str
    scope: str
    shutdown_when_idle: bool
    auto_shutdown: bool


# Any: functions, and what pytest makes of them.
known: dict[Any, LaunchFixture] = {}
"""By the function, and by the fixture that pytest makes of it."""

_running: WeakKeyDictionary[LaunchService, tuple[asyncio.Task[int], bool]] = WeakKeyDictionary()


def begin(
    service: LaunchService, fixture: LaunchFixture, loop: asyncio.AbstractEventLoop
) -> asyncio.Task[int]:
    """Start the launch of a service as a task of an event loop."""
    task = loop.create_task(service.run_async(shutdown_when_idle=fixture.shutdown_when_idle))
    _running[service] = (task, fixture.auto_shutdown)
    return task


def finish(service: LaunchService) -> None:
    """Wait for the end of a launch, and shut it down first if its fixture requests that.

    Raises:
        AssertionError: Something of the launch itself has failed.
    """
    task, auto_shutdown = _running.pop(service, (None, False))
    if task is None or task.get_loop().is_closed():
        return
    if auto_shutdown:
        service.shutdown(force_sync=True)
    status = task.get_loop().run_until_complete(task)
    assert status == 0, f"the launch service has failed, return code '{status}'"

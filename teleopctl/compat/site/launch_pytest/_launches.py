"""Launches of fixtures: how they are to run, and how they end."""

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
    """What is known of a fixture that returns a launch description.

    Attributes:
        name: The fixture's name.
        scope: The fixture's scope.
        shutdown_when_idle: Whether its launch ends when nothing is left.
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
    """Launch what a service has been given, beside other tasks of a loop."""
    task = loop.create_task(service.run_async(shutdown_when_idle=fixture.shutdown_when_idle))
    _running[service] = (task, fixture.auto_shutdown)
    return task


def finish(service: LaunchService) -> None:
    """Wait for the end of a launch, where it runs, and end it where that is to be done.

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

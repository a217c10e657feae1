"""``launch_pytest.fixture``: fixtures of launches, their services, contexts and event loops."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from launch import LaunchContext, LaunchService

from ._launches import SCOPES, LaunchFixture, finish, known

# Fixtures that one of a wider scope may replace. Any: what pytest makes of a function.
_overridable: dict[Any, str] = {}


# Any: what pytest makes of a function.
def get_launch_service_fixture(*, scope: Any = "function", overridable: bool = True) -> Any:
    """Return a fixture that provides a launch service."""

    @pytest.fixture(scope=scope)
    def launch_service(event_loop: asyncio.AbstractEventLoop) -> Iterator[LaunchService]:  # noqa: ARG001 -- which ends after it
        """Launch service of the test's launch."""
        service = LaunchService()
        yield service
        finish(service)

    return _made(launch_service, scope, overridable)


def get_launch_context_fixture(*, scope: Any = "function", overridable: bool = True) -> Any:
    """Return a fixture that provides the context of the launch service."""

    @pytest.fixture(scope=scope)
    def launch_context(launch_service: LaunchService) -> LaunchContext:
        """Launch context of the test's launch."""
        return launch_service.context

    return _made(launch_context, scope, overridable)


def get_event_loop_fixture(*, scope: Any = "function", overridable: bool = True) -> Any:
    """Return a fixture that provides an event loop."""

    @pytest.fixture(scope=scope)
    def event_loop() -> Iterator[asyncio.AbstractEventLoop]:
        """Event loop of the test and its launch."""
        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        yield loop
        asyncio.set_event_loop(None)
        loop.close()

    return _made(event_loop, scope, overridable)


def _made(definition: Any, scope: str, overridable: bool) -> Any:
    if overridable:
        _overridable[definition] = scope
    return definition


_COMPANIONS = {
    "event_loop": get_event_loop_fixture,
    "launch_service": get_launch_service_fixture,
    "launch_context": get_launch_context_fixture,
}


# Any: arguments of `pytest.fixture`, and what it makes of a function.
def fixture(
    decorated: Callable[..., Any] | None = None,
    *,
    shutdown_when_idle: bool = True,
    auto_shutdown: bool = True,
    **kwargs: Any,
) -> Any:
    """Turn a function that returns a launch description, alone or first in a tuple, into a fixture.

    The fixture's launch runs when the fixture is there, and its ``ReadyToTest``, where it has one,
    has been reached. In the function's module, ``launch_service``, ``launch_context`` and
    ``event_loop`` get the same scope, unless the module has its own.

    Args:
        decorated: The function, where the decorator stands without brackets.
        shutdown_when_idle: Whether the launch ends when nothing is left.
        auto_shutdown: Whether it is ended when the tests beside it have run; else it has to end
            by itself.
        kwargs: Further arguments of `pytest.fixture`.
    """
    scope = kwargs.get("scope", "function")
    if scope != "function":
        _widen(sys._getframe(1).f_globals, scope)  # noqa: SLF001 -- the module is still being imported

    def decorate(function: Callable[..., Any]) -> Any:
        definition = pytest.fixture(**kwargs)(function)
        known[function] = known[definition] = LaunchFixture(
            kwargs.get("name") or function.__name__, scope, shutdown_when_idle, auto_shutdown
        )
        return definition

    return decorate if decorated is None else decorate(decorated)


def _widen(module: dict[str, Any], scope: str) -> None:
    for name, make in _COMPANIONS.items():
        # A fixture that the module defines itself is kept.
        own = _overridable.get(module[name]) if name in module else "function"
        if own is not None and SCOPES.index(own) < SCOPES.index(scope):
            module[name] = make(scope=scope)

"""``launch_pytest.plugin``: runs functions marked with ``@pytest.mark.launch(fixture=…)``.

Such a function is replaced by one without ``async`` and ``yield``, which drives the event loop
while it runs. Of one that yields, what stands behind the ``yield`` runs when the launch has ended:
at once for a fixture of the function alone, and as a test of its own, behind all others of the
fixture, for a wider one.
"""

from __future__ import annotations

import asyncio
import functools
import inspect
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from typing import Any

import pytest
from launch import LaunchDescription, LaunchService
from launch_testing.loader import ready_to_test_actions

from ._launches import LaunchFixture, begin, finish, known
from .actions import ReadyToTest
from .fixture import (
    get_event_loop_fixture,
    get_launch_context_fixture,
    get_launch_service_fixture,
)

launch_service = get_launch_service_fixture(overridable=False)
launch_context = get_launch_context_fixture(overridable=False)
event_loop = get_event_loop_fixture(overridable=False)

_ALSO_ASKED_FOR = ("request", "launch_service", "event_loop")
_SHUTDOWN = "[shutdown_test]"
_END = object()
# Attribute that marks a function made for a test.
_MARK = "_launch_test"


class LaunchTestWarning(pytest.PytestWarning):
    """Warning about a function with the ``launch`` mark that is not run."""


# Any: what fixtures return.
@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_fixture_setup(
    fixturedef: pytest.FixtureDef[Any], request: pytest.FixtureRequest
) -> Generator[None, Any, Any]:
    """Start the launch of a fixture, and wait until it is ready for tests."""
    fixture = known.get(getattr(fixturedef.func, "__func__", fixturedef.func))
    if fixture is None:
        return (yield)
    service: LaunchService = request.getfixturevalue("launch_service")
    loop: asyncio.AbstractEventLoop = request.getfixturevalue("event_loop")
    returned = yield
    description = returned[0] if isinstance(returned, Sequence) and returned else returned
    if not isinstance(description, LaunchDescription):
        raise TypeError(
            f"launch_pytest fixture '{fixture.name}': return value must be either a launch "
            "description or a sequence which first item is a launch description"
        )
    # The service may have a wider scope in this module.
    fixturedef.addfinalizer(functools.partial(finish, service))
    _wait_until_ready(service, fixture, loop, description)
    return returned


def _wait_until_ready(
    service: LaunchService,
    fixture: LaunchFixture,
    loop: asyncio.AbstractEventLoop,
    description: LaunchDescription,
) -> None:
    found = list(ready_to_test_actions(description.entities))
    if len(found) > 1:
        raise RuntimeError(
            f"launch_pytest fixture '{fixture.name}': the LaunchDescription may contain only one "
            "ReadyToTest action"
        )
    if not found:
        found = [ReadyToTest()]
        description.add_entity(found[0])
    is_ready = asyncio.Event()
    found[0].add_callback(lambda: loop.call_soon_threadsafe(is_ready.set))
    service.include_launch_description(description)
    task = begin(service, fixture, loop)

    async def ready_or_ended() -> None:
        ready = loop.create_task(is_ready.wait())
        await asyncio.wait((task, ready), return_when=asyncio.FIRST_COMPLETED)
        ready.cancel()

    loop.run_until_complete(ready_or_ended())
    if not is_ready.is_set():
        finish(service)
        raise RuntimeError(
            f"launch_pytest fixture '{fixture.name}': the launch has ended before it was ready"
        )


# Any: whatever is defined in a module.
@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makeitem(
    collector: pytest.Module | pytest.Class, name: str, obj: Any
) -> list[pytest.Item | pytest.Collector] | None:
    """Collect a function with the ``launch`` mark."""
    if not inspect.isfunction(obj) or not collector.funcnamefilter(name):
        return None
    own = [mark for mark in getattr(obj, "pytestmark", []) if mark.name == "launch"]
    mark = own[0] if own else collector.get_closest_marker("launch")
    if mark is None or hasattr(obj, _MARK):
        return None
    function: Any = obj
    fixture = known.get(mark.kwargs.get("fixture"))
    yields = inspect.isgeneratorfunction(function) or inspect.isasyncgenfunction(function)
    tests: dict[str, Callable[..., None]] = {}
    if fixture is None:
        text = '"fixture" keyword argument is required in a pytest.mark.launch() decorator'
        collector.warn(LaunchTestWarning(f"{name}: {text}"))
        tests[name] = pytest.mark.skip(text)(_replaced(function, _skipped, None))
    elif yields and mark.kwargs.get("shutdown", False):
        tests[name] = _replaced(function, _refused, fixture)
    elif yields:
        halves = _Halves(function, fixture)
        tests[name] = _replaced(function, halves.first, fixture)
        if fixture.scope != "function":
            behind = _replaced(function, halves.second, fixture)
            others = [mark for mark in getattr(function, "pytestmark", []) if mark not in own]
            behind.pytestmark = others  # type: ignore[attr-defined]
            marked = pytest.mark.launch(fixture=mark.kwargs["fixture"], shutdown=True)
            tests[name + _SHUTDOWN] = marked(behind)
    else:
        is_behind = mark.kwargs.get("shutdown", False)
        run = functools.partial(_run_whole, function, is_behind)
        tests[name] = _replaced(function, run, fixture)
    items: list[pytest.Item | pytest.Collector] = []
    for called, test in tests.items():
        # pytest looks the function up in the module by its name again.
        setattr(collector.obj, called, test)
        made = collector.ihook.pytest_pycollect_makeitem(collector=collector, name=called, obj=test)
        items += made or []
    return items


def _replaced(
    function: Callable[..., Any], run: Callable[..., None], fixture: LaunchFixture | None
) -> Callable[..., None]:
    """Return a plain test function that requests the launch's fixtures in addition to its own."""
    asked = inspect.signature(function).parameters
    also = _ALSO_ASKED_FOR if fixture is not None else ()
    further = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY)
        for name in also
        if name not in asked
    ]

    @functools.wraps(function)
    def test(*args: Any, **kwargs: Any) -> None:
        launch = {name: kwargs[name] for name in also}
        own = {name: value for name, value in kwargs.items() if name in asked}
        run(functools.partial(function, *args, **own), **launch)

    setattr(test, _MARK, True)
    test.__signature__ = inspect.Signature([*asked.values(), *further])  # type: ignore[attr-defined]
    return test if fixture is None else pytest.mark.usefixtures(fixture.name)(test)


def _skipped(_: Callable[..., Any]) -> None:
    """Do nothing: placeholder of a step that is never called."""


def _refused(_: Callable[..., Any], **__: Any) -> None:
    pytest.fail(
        "generator or async generator based launch test items cannot be marked with shutdown=True",
        pytrace=False,
    )


def _run_whole(
    function: Callable[..., Any],
    is_behind: bool,
    call: Callable[..., Any],
    *,
    request: pytest.FixtureRequest,  # noqa: ARG001 -- same signature for all
    launch_service: LaunchService,
    event_loop: asyncio.AbstractEventLoop,
) -> None:
    if is_behind:
        finish(launch_service)
    if inspect.iscoroutinefunction(function):
        event_loop.run_until_complete(call())
    else:
        event_loop.run_until_complete(event_loop.run_in_executor(None, call))


class _Halves:
    """A test that yields, as two steps: before the ``yield`` and after it.

    Args:
        function: The test.
        fixture: The fixture that it uses.
    """

    def __init__(self, function: Callable[..., Any], fixture: LaunchFixture) -> None:
        self._is_async = inspect.isasyncgenfunction(function)
        self._fixture = fixture
        # By the values of a parametrized test.
        self._halted: dict[str, Any] = {}

    def first(
        self,
        call: Callable[..., Any],
        *,
        request: pytest.FixtureRequest,
        launch_service: LaunchService,
        event_loop: asyncio.AbstractEventLoop,
    ) -> None:
        """Run the test up to the ``yield``, and the rest if the launch ends with it."""
        generator = call()
        if self._next(generator, event_loop) is _END:
            pytest.fail("a launch test that is a generator must yield once", pytrace=False)
        if self._fixture.scope == "function":
            finish(launch_service)
            self._end(generator, event_loop)
        else:
            self._halted[_values(request)] = generator

    def second(
        self,
        _: Callable[..., Any],
        *,
        request: pytest.FixtureRequest,
        launch_service: LaunchService,
        event_loop: asyncio.AbstractEventLoop,
    ) -> None:
        """Run the test from the ``yield`` on."""
        generator = self._halted.pop(_values(request), None)
        if generator is None:
            pytest.skip("shutdown test skipped because the test failed before")
        finish(launch_service)
        self._end(generator, event_loop)

    def _end(self, generator: Any, loop: asyncio.AbstractEventLoop) -> None:
        if self._next(generator, loop) is not _END:
            pytest.fail(
                "launch tests using a generator function must stop iteration after yielding once",
                pytrace=False,
            )

    def _next(self, generator: Any, loop: asyncio.AbstractEventLoop) -> Any:
        if not self._is_async:
            return loop.run_until_complete(loop.run_in_executor(None, next, generator, _END))

        async def step() -> Any:
            return await anext(generator, _END)

        return loop.run_until_complete(step())


def _values(request: pytest.FixtureRequest) -> str:
    callspec = getattr(request.node, "callspec", None)
    return "" if callspec is None else str(callspec.id)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Move tests of a shut-down launch behind the other tests of their fixture."""
    items[:] = _in_order(items)


def _in_order(items: Iterable[pytest.Item]) -> Iterator[pytest.Item]:
    items = list(items)
    last: dict[object, int] = {}
    for index, item in enumerate(items):
        group, is_behind = _group(item)
        if group is not None and not is_behind:
            last[group] = index
    waiting: dict[object, list[pytest.Item]] = {}
    for index, item in enumerate(items):
        group, is_behind = _group(item)
        if is_behind and last.get(group, -1) > index:
            waiting.setdefault(group, []).append(item)
            continue
        yield item
        if last.get(group) == index:
            yield from waiting.pop(group, ())


def _group(item: pytest.Item) -> tuple[object, bool]:
    """Return a key that tests of one launch share, and whether the test runs after its shutdown."""
    mark = item.get_closest_marker("launch")
    fixture = known.get(mark.kwargs.get("fixture")) if mark is not None else None
    if mark is None or fixture is None or fixture.scope == "function":
        return None, False
    callspec = getattr(item, "callspec", None)
    value = callspec.params.get(fixture.name) if callspec is not None else None
    return (fixture, repr(value)), bool(mark.kwargs.get("shutdown", False))

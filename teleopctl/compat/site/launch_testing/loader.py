"""``launch_testing.loader``: test runs of a module: its launch descriptions and their tests."""

from __future__ import annotations

import functools
import inspect
import unittest
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import ModuleType
from typing import Any

from launch import LaunchDescription, LaunchDescriptionEntity

from ._marks import IS_AFTER_SHUTDOWN, IS_PARAMETRIZED, MARKERS, TIMEOUT
from .actions import ReadyToTest

_READY_WITHIN_S = 15.0

# Any: functions of a test description have any arguments and results.
Description = Callable[..., Any]


class TestRun:
    """A launch description with its tests.

    Args:
        name: Name in reports.
        test_description_function: Returns the launch description, alone or with a mapping of
            further arguments for tests.
        param_args: Arguments of the function.
        pre_shutdown_tests: Tests that run beside the processes.
        post_shutdown_tests: Tests that run when all processes have ended.

    Attributes:
        name: Name in reports.
        test_description_function: The function.
        param_args: Arguments of the function.
        pre_shutdown_tests: Tests that run beside the processes.
        post_shutdown_tests: Tests that run when all processes have ended.
        timeout: Seconds until ``ReadyToTest`` has to be reached.
    """

    __test__ = False  # to pytest

    def __init__(
        self,
        name: str,
        test_description_function: Description,
        param_args: Mapping[str, Any],
        pre_shutdown_tests: Iterable[Any],
        post_shutdown_tests: Iterable[Any],
    ) -> None:
        self.name = name
        self.test_description_function = test_description_function
        self.param_args = param_args
        self.pre_shutdown_tests = unittest.TestSuite(pre_shutdown_tests)
        self.post_shutdown_tests = unittest.TestSuite(post_shutdown_tests)
        # A suite drops its tests when it has run.
        self._cases = [*_cases(self.pre_shutdown_tests), *_cases(self.post_shutdown_tests)]
        self.timeout: float = getattr(test_description_function, TIMEOUT, _READY_WITHIN_S)
        if param_args:
            for case in self._cases:
                plain = case._testMethodName  # noqa: SLF001 -- unittest has no public attribute for it
                called = plain + self._values()
                setattr(case, called, getattr(case, plain))
                case._testMethodName = called  # noqa: SLF001

    @property
    def markers(self) -> dict[str, Any]:
        """Markers of the function, such as ``keep_alive``."""
        return getattr(self.test_description_function, MARKERS, {})

    def normalized_test_description(
        self, *, ready_fn: Callable[[], object]
    ) -> tuple[LaunchDescription, dict[str, Any]]:
        """Return a new launch description, and the further arguments for the tests.

        Args:
            ready_fn: Called when its ``ReadyToTest`` is reached.

        Raises:
            RuntimeError: The description has no ``ReadyToTest``.
        """
        result = self.test_description_function()
        description, context = result if isinstance(result, tuple) else (result, {})
        ready = next(ready_to_test_actions(description.entities), None)
        if ready is None:
            raise RuntimeError(
                "generate_test_description functions must return a LaunchDescription containing a "
                "ReadyToTest action"
            )
        ready.add_callback(ready_fn)
        return description, context

    def get_launch_description(self) -> LaunchDescription:
        """Return a launch description for inspection, not for launching."""
        return self.normalized_test_description(ready_fn=lambda: None)[0]

    def bind(
        self,
        tests: unittest.TestSuite,
        injected_attributes: Mapping[str, Any],
        injected_args: Mapping[str, Any],
    ) -> None:
        """Pass fixtures to tests, by the names of their arguments.

        Args:
            tests: The tests.
            injected_attributes: Attributes to set on the tests, for old ones.
            injected_args: Arguments that tests may have.
        """
        cases = list(_cases(tests))
        for case in cases:
            for name in (case._testMethodName, "setUp", "tearDown"):  # noqa: SLF001
                setattr(case, name, _bound(getattr(case, name), injected_args))
        for test_class in dict.fromkeys(map(type, cases)):
            for name in ("setUpClass", "tearDownClass"):
                setattr(test_class, name, _bound(getattr(test_class, name), injected_args))
            for name, value in injected_attributes.items():
                setattr(test_class, name, _deprecated(name, value))

    def all_cases(self) -> Iterator[unittest.TestCase]:
        """Yield the tests."""
        yield from self._cases

    def _values(self) -> str:
        return f"[{', '.join(map(str, self.param_args.values()))}]" if self.param_args else ""

    def __str__(self) -> str:
        return self.name + self._values()


def ready_to_test_actions(entities: Iterable[LaunchDescriptionEntity]) -> Iterator[ReadyToTest]:
    """Yield the ``ReadyToTest`` actions among entities and below them."""
    for entity in entities:
        if isinstance(entity, ReadyToTest):
            yield entity
        yield from ready_to_test_actions(entity.describe_sub_entities())
        for _, inner in entity.describe_conditional_sub_entities():
            yield from ready_to_test_actions(inner)


def LoadTestsFromPythonModule(  # noqa: N802 -- the original's name
    module: ModuleType, *, name: str = "launch_tests"
) -> list[TestRun]:
    """Return the test runs of a module: one for each launch description.

    Args:
        module: Has ``generate_test_description`` and classes of tests.
        name: Name in reports.
    """
    function = module.generate_test_description
    descriptions: Iterable[tuple[Description, Mapping[str, Any]]] = [(function, {})]
    if hasattr(function, IS_PARAMETRIZED):
        descriptions = function()
    return [
        TestRun(
            name,
            description,
            arguments,
            PreShutdownTestLoader().loadTestsFromModule(module),
            PostShutdownTestLoader().loadTestsFromModule(module),
        )
        for description, arguments in descriptions
    ]


class PreShutdownTestLoader(unittest.TestLoader):
    """Loader of the tests that run beside the processes."""

    _after_shutdown = False

    def loadTestsFromTestCase(  # noqa: N802 -- unittest's name
        self,
        testCaseClass: type[unittest.TestCase],  # noqa: N803 -- unittest's name
    ) -> unittest.TestSuite:
        """Return the tests of a class, bound to this run by a subclass."""
        if getattr(testCaseClass, IS_AFTER_SHUTDOWN, False) != self._after_shutdown:
            return unittest.TestSuite()
        own = {"__module__": testCaseClass.__module__, "__qualname__": testCaseClass.__qualname__}
        return super().loadTestsFromTestCase(type(testCaseClass.__name__, (testCaseClass,), own))


class PostShutdownTestLoader(PreShutdownTestLoader):
    """Loader of the tests that run after all processes have exited."""

    _after_shutdown = True


def _cases(tests: Iterable[Any]) -> Iterator[Any]:
    for test in tests:
        if isinstance(test, unittest.TestSuite):
            yield from _cases(test)
        else:
            yield test


# Any: arguments of tests.
def _bound(function: Callable[..., Any], arguments: Mapping[str, Any]) -> Callable[..., Any]:
    wanted = inspect.signature(function).parameters
    given = {name: value for name, value in arguments.items() if name in wanted}
    return functools.partial(function, **given) if given else function


def _deprecated(name: str, value: Any) -> property:
    def get(_: object) -> Any:
        warnings.warn(
            f"self.{name} will go in a later release of launch_testing: make {name} an argument "
            "of the test",
            stacklevel=2,
        )
        return value

    return property(get)

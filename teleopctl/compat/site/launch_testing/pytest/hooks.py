"""``launch_testing.pytest.hooks``: collection of files with a launch test as pytest items.

Its ``generate_test_description`` is marked with ``@pytest.mark.launch_test`` (or ``rostest``). A
file without that mark is collected as any other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from ..loader import LoadTestsFromPythonModule
from ..test_runner import LaunchTestRunner

if TYPE_CHECKING:
    from ..test_runner import Result

_FUNCTION = "generate_test_description"
_MARKS = {"launch_test", "rostest"}


class LaunchTestFailure(Exception):
    """Raised when tests of a launch have failed.

    Args:
        results: The results of the file's launches.
    """

    def __init__(self, results: Iterable[Result]) -> None:
        super().__init__("some test cases have failed")
        self.results = list(results)

    def report(self) -> str:
        """Return a report of the failed tests."""
        return "\n\n".join(
            f"FAIL: {case.id()}\n{'-' * 70}\n{told}"
            for result in self.results
            for case, told in [*result.errors, *result.failures]
        )


class LaunchTestItem(pytest.Item):
    """Pytest item with the launches and tests of a file."""

    def runtest(self) -> None:
        """Run the launches and tests.

        Raises:
            LaunchTestFailure: Some have failed.
        """
        assert isinstance(self.parent, LaunchTestModule)
        module = self.parent.obj
        arguments = [word for words in self.config.getoption("--launch-args") for word in words]
        runner = LaunchTestRunner(
            LoadTestsFromPythonModule(module, name=module.__name__),
            arguments,
            debug=bool(self.config.getoption("verbose")),
        )
        runner.validate()
        results = runner.run().values()
        if not all(result.wasSuccessful() for result in results):
            raise LaunchTestFailure(results)

    # Any: pytest has no public name for its styles.
    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> str:
        """Return pytest's text of a failure."""
        if isinstance(excinfo.value, LaunchTestFailure):
            return excinfo.value.report()
        return str(super().repr_failure(excinfo, style))

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return the location of the item."""
        return self.path, 0, f"launch tests: {self.name}"


class LaunchTestModule(pytest.Module):
    """Pytest module that may contain a launch test."""

    def collect(self) -> Iterator[pytest.Item | pytest.Collector]:
        """Yield the file's launch test, or its ordinary tests."""
        marks = getattr(getattr(self.obj, _FUNCTION, None), "pytestmark", [])
        if not any(mark.name in _MARKS for mark in marks):
            yield from super().collect()
            return
        for mark in marks:
            self.add_marker(getattr(pytest.mark, mark.name).with_args(*mark.args, **mark.kwargs))
        yield LaunchTestItem.from_parent(self, name=self.obj.__name__.rpartition(".")[2])


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makemodule(
    module_path: Path, parent: pytest.Collector
) -> LaunchTestModule | None:
    """Return a `LaunchTestModule` for each Python file."""
    if _FUNCTION.encode() in module_path.read_bytes():
        return LaunchTestModule.from_parent(parent, path=module_path)
    return None

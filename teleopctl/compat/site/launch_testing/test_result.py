"""``launch_testing.test_result``: results of test runs, with the duration of each test."""

from __future__ import annotations

import time
import unittest
from collections.abc import Collection
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .loader import TestRun


class FailResult(unittest.TestResult):
    """Result of a launch that failed, and all its tests with it.

    Args:
        test_run: The launch.
        message: Why.
    """

    def __init__(self, test_run: TestRun, message: str) -> None:
        super().__init__()
        self._cases = list(test_run.all_cases())
        for case in self._cases:
            self.failures.append((case, message))
            self.testsRun += 1

    @property
    def testCases(self) -> list[unittest.TestCase]:  # noqa: N802 -- the original's name
        """The tests."""
        return self._cases

    @property
    def testTimes(self) -> dict[unittest.TestCase, float]:  # noqa: N802 -- the original's name
        """Durations of the tests in seconds: none."""
        return dict.fromkeys(self._cases, 0.0)

    def wasSuccessful(self) -> bool:  # noqa: N802 -- unittest's name
        """Return False, also if there are no tests."""
        return False


class SkipResult(unittest.TestResult):
    """Result of a launch that is skipped with its tests.

    Args:
        test_run: The launch.
        skip_reason: Why.
    """

    def __init__(self, test_run: TestRun, skip_reason: str = "") -> None:
        super().__init__()
        self._cases = list(test_run.all_cases())
        for case in self._cases:
            self.addSkip(case, skip_reason)
            self.testsRun += 1

    @property
    def testCases(self) -> list[unittest.TestCase]:  # noqa: N802 -- the original's name
        """The tests."""
        return self._cases

    @property
    def testTimes(self) -> dict[unittest.TestCase, float]:  # noqa: N802 -- the original's name
        """Durations of the tests in seconds: none."""
        return dict.fromkeys(self._cases, 0.0)


class TestResult(unittest.TextTestResult):
    """Result with each test and its duration."""

    __test__ = False  # to pytest

    # Any: arguments of `TextTestResult.`
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._began: dict[unittest.TestCase, float] = {}
        self._took: dict[unittest.TestCase, float] = {}

    @property
    def testCases(self) -> Collection[unittest.TestCase]:  # noqa: N802 -- the original's name
        """The tests."""
        return self._took.keys()

    @property
    def testTimes(self) -> dict[unittest.TestCase, float]:  # noqa: N802 -- the original's name
        """Durations of the tests in seconds."""
        return dict(self._took)

    def startTest(self, test: unittest.TestCase) -> None:  # noqa: N802 -- unittest's name
        """Record the start of a test."""
        self._began[test] = time.monotonic()
        self._took[test] = 0.0
        super().startTest(test)

    def stopTest(self, test: unittest.TestCase) -> None:  # noqa: N802 -- unittest's name
        """Record the end of a test."""
        now_s = time.monotonic()
        # Python 3.12.1 does not start tests that are skipped.
        self._took[test] = now_s - self._began.pop(test, now_s)
        super().stopTest(test)

    def append(self, results: TestResult) -> None:
        """Add the results of further tests."""
        self._took |= results.testTimes
        self.testsRun += results.testsRun
        self.failures += results.failures
        self.errors += results.errors
        self.skipped += results.skipped
        self.expectedFailures += results.expectedFailures
        self.unexpectedSuccesses += results.unexpectedSuccesses

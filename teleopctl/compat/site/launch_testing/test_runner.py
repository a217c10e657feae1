"""``launch_testing.test_runner``: runner of launches with their tests."""

from __future__ import annotations

import inspect
import threading
import unittest
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from launch import (
    LaunchDescription,
    LaunchDescriptionEntity,
    LaunchDescriptionSource,
    LaunchService,
)
from launch.actions import IncludeLaunchDescription, RegisterEventHandler
from launch.event_handlers import OnProcessExit, OnProcessIO, OnProcessStart
from launch.events.process import ProcessExited

from .io_handler import ActiveIoHandler
from .parse_arguments import parse_launch_arguments
from .proc_info_handler import ActiveProcInfoHandler
from .test_result import FailResult, SkipResult, TestResult

if TYPE_CHECKING:
    from .loader import TestRun

    Result = FailResult | SkipResult | TestResult


class _LaunchDiedError(Exception):
    """Raised when a launch ends before its tests."""


class _RunnerWorker:
    """Runs a launch on the main thread, and its tests on another thread.

    The launch must run on the main thread, since only that receives SIGINT.
    """

    def __init__(
        self,
        test_run: TestRun,
        preamble: Iterable[LaunchDescriptionEntity],
        launch_file_arguments: Iterable[str],
        debug: bool,
    ) -> None:
        self._test_run = test_run
        self._preamble = preamble
        self._arguments = parse_launch_arguments(launch_file_arguments)
        self._launch_service = LaunchService(debug=debug)
        self._info = ActiveProcInfoHandler()
        self._output = ActiveIoHandler()
        self._is_ready = threading.Event()
        self._result: TestResult | None = None

    def run(self) -> TestResult:
        """Run the launch and the tests; return the results.

        Raises:
            _LaunchDiedError: The launch has ended before the tests had.
            unittest.SkipTest: The test description raises it, to be skipped.
        """
        description, context = self._test_run.normalized_test_description(
            ready_fn=self._is_ready.set
        )
        arguments = {**context, **self._test_run.param_args, "test_args": dict(self._arguments)}
        active = {
            "launch_service": self._launch_service,
            "proc_info": self._info,
            "proc_output": self._output,
            "test_args": arguments["test_args"],
        }
        ended = {
            "proc_info": self._info.proc_info_handler,
            "proc_output": self._output.io_handler,
            "test_args": arguments["test_args"],
        }
        self._test_run.bind(self._test_run.pre_shutdown_tests, active, arguments | active)
        self._test_run.bind(self._test_run.post_shutdown_tests, ended, arguments | ended)
        self._launch_service.include_launch_description(self._recorded(description))
        tests = threading.Thread(target=self._run_test, name="launch-tests", daemon=True)
        tests.start()
        self._launch_service.run(
            shutdown_when_idle=not self._test_run.markers.get("keep_alive", False)
        )
        if self._result is None:
            print("Processes under test stopped before tests completed")  # noqa: T201 -- output for the user
            self._print_failed_output()
            raise _LaunchDiedError
        tests.join()
        self._result.append(_run(self._test_run.post_shutdown_tests))
        return self._result

    def _recorded(self, description: LaunchDescription) -> LaunchDescription:
        """Return a launch description that includes another one and records its events."""
        return LaunchDescription(
            [
                *self._preamble,
                RegisterEventHandler(
                    OnProcessStart(on_start=lambda event, _: self._output.track(event.process_name))
                ),
                RegisterEventHandler(
                    OnProcessStart(on_start=lambda event, _: self._info.append(event))
                ),
                RegisterEventHandler(
                    OnProcessExit(on_exit=lambda event, _: self._info.append(event))
                ),
                RegisterEventHandler(
                    OnProcessIO(on_stdout=self._output.append, on_stderr=self._output.append)
                ),
                IncludeLaunchDescription(
                    LaunchDescriptionSource(description), launch_arguments=self._arguments
                ),
            ]
        )

    def _run_test(self) -> None:
        """Run the tests once the launch is ready, and shut it down."""
        try:
            if self._is_ready.wait(self._test_run.timeout):
                self._result = _run(self._test_run.pre_shutdown_tests)
            else:
                print("Timed out waiting for processes to start up")  # noqa: T201 -- likewise
        finally:
            self._launch_service.shutdown()

    def _print_failed_output(self) -> None:
        for event in self._info:
            if not isinstance(event, ProcessExited) or event.returncode == 0:
                continue
            head = f"##### '{event.process_name}' output #####"
            written = "".join(
                each.text.decode(errors="replace") for each in self._output[event.process_name]
            )
            lines = [f"Process '{event.process_name}' exited with {event.returncode}", head]
            print("\n".join([*lines, written.rstrip("\n"), "#" * len(head)]))  # noqa: T201 -- likewise


def _run(tests: unittest.TestSuite) -> TestResult:
    result = unittest.TextTestRunner(verbosity=2, resultclass=TestResult).run(tests)
    assert isinstance(result, TestResult)
    return result


class LaunchTestRunner:
    """Runner of launches with their tests, one after another.

    Args:
        test_runs: The launches.
        launch_file_arguments: Arguments of the launches: ``name:=value``.
        debug: Whether lines for finding mistakes are shown.
    """

    def __init__(
        self,
        test_runs: Sequence[TestRun],
        launch_file_arguments: Iterable[str] = (),
        debug: bool = False,
    ) -> None:
        self._test_runs = test_runs
        self._arguments = list(launch_file_arguments)
        self._debug = debug

    def generate_preamble(self) -> list[LaunchDescriptionEntity]:
        """Return a launch description to run before the tested one: empty by default."""
        return []

    def run(self) -> dict[TestRun, Result]:
        """Run each launch; return the results, up to the first launch that ends too early."""
        results: dict[TestRun, Result] = {}
        for run in self._test_runs:
            if len(self._test_runs) > 1:
                print(f"\nStarting test run {run}")  # noqa: T201 -- output for the user
            worker = _RunnerWorker(run, self.generate_preamble(), self._arguments, self._debug)
            try:
                results[run] = worker.run()
            except unittest.SkipTest as reason:
                print(f"{run} is skipped: {reason}")  # noqa: T201 -- likewise
                results[run] = SkipResult(run, str(reason))
            except _LaunchDiedError:
                results[run] = FailResult(run, "Launch stopped before the active tests finished.")
                break
        return results

    def validate(self) -> None:
        """Check that the functions that return launch descriptions take the given arguments.

        Raises:
            TypeError: One does not.
        """
        for run in self._test_runs:
            taken = inspect.signature(inspect.unwrap(run.test_description_function)).parameters
            for name in run.param_args:
                if name not in taken:
                    raise TypeError(
                        "Could not find an argument in generate_test_description matching "
                        f"parametrized argument '{name}'"
                    )
            for name in taken:
                if name not in run.param_args:
                    raise TypeError(
                        f"generate_test_description has unexpected extra argument '{name}'"
                    )

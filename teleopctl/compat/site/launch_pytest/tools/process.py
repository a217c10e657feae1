"""``launch_pytest.tools.process``: waits for events and output of processes of a launch.

Each comes twice: to be awaited, and with ``_sync`` for tests that are no coroutines. What has
happened already counts.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TypeVar

from launch import LaunchContext
from launch.actions import ExecuteLocal
from launch.event_handlers import OnProcessExit, OnProcessIO, OnProcessStart

_Value = TypeVar("_Value")

# Returns a true value when the condition holds.
Condition = Callable[[], _Value]
# Returns whether output is as expected, or raises AssertionError.
Validate = Callable[[str], object]


@contextmanager
def _watched(
    context: LaunchContext, process: ExecuteLocal, changed: Callable[[], object]
) -> Iterator[None]:
    """Call a function, on the launch's thread, at each event of a process."""

    def on_event(*_: object) -> None:
        changed()

    handlers = [
        OnProcessStart(target_action=process, on_start=on_event),
        OnProcessExit(target_action=process, on_exit=on_event),
        OnProcessIO(target_action=process, on_stdout=on_event, on_stderr=on_event),
    ]
    for handler in handlers:
        # After the action's own handler, which records the event.
        context.register_event_handler(handler, append=True)
    try:
        yield
    finally:
        for handler in handlers:
            context.unregister_event_handler(handler)


async def _wait(
    context: LaunchContext,
    process: ExecuteLocal,
    condition: Condition[_Value],
    timeout: float | None,
) -> _Value:
    loop = asyncio.get_running_loop()
    changed = asyncio.Event()

    async def wait() -> None:
        while not condition():
            await changed.wait()
            changed.clear()

    with _watched(context, process, lambda: loop.call_soon_threadsafe(changed.set)):
        with suppress(TimeoutError):
            await asyncio.wait_for(wait(), timeout)
        return condition()


def _wait_sync(
    context: LaunchContext,
    process: ExecuteLocal,
    condition: Condition[_Value],
    timeout: float | None,
) -> _Value:
    changed = threading.Event()
    end = None if timeout is None else time.monotonic() + timeout
    with _watched(context, process, changed.set):
        while not (value := condition()):
            left = None if end is None else max(0.0, end - time.monotonic())
            if not changed.wait(left):
                return condition()
            changed.clear()
        return value


def _holds(validate: Validate, written: Callable[[], str]) -> Condition[bool]:
    def condition() -> bool:
        try:
            validate(written())
        except AssertionError:
            return False
        return True

    return condition


async def wait_for_output(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> object:
    """Wait until the stdout of a process passes a check.

    Args:
        launch_context: The launch.
        execute_process_action: The process; its output is cached.
        validate_output: Called with the output; returns whether it passes.
        timeout: Seconds to wait; None for as long as it takes.

    Returns:
        What `validate_output` has returned last.
    """
    process = execute_process_action
    return await _wait(
        launch_context, process, lambda: validate_output(process.get_stdout()), timeout
    )


async def wait_for_stderr(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> object:
    """Wait until the stderr of a process passes a check; see `wait_for_output`."""
    process = execute_process_action
    return await _wait(
        launch_context, process, lambda: validate_output(process.get_stderr()), timeout
    )


async def assert_output(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> None:
    """Wait until the stdout of a process passes a check that raises AssertionError.

    Args:
        launch_context: The launch.
        execute_process_action: The process; its output is cached.
        validate_output: Called with the output, raises AssertionError where it does not.
        timeout: Seconds to wait; None for as long as it takes.

    Raises:
        AssertionError: It does not before the timeout.
    """
    written = execute_process_action.get_stdout
    condition = _holds(validate_output, written)
    if not await _wait(launch_context, execute_process_action, condition, timeout):
        validate_output(written())


async def assert_stderr(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> None:
    """Wait until the stderr of a process passes a check; see `assert_output`."""
    written = execute_process_action.get_stderr
    condition = _holds(validate_output, written)
    if not await _wait(launch_context, execute_process_action, condition, timeout):
        validate_output(written())


async def wait_for_start(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    timeout: float | None = None,
) -> bool:
    """Wait until a process has started; return whether it has.

    Args:
        launch_context: The launch.
        execute_process_action: The process.
        timeout: Seconds to wait; None for as long as it takes.
    """
    process = execute_process_action
    return await _wait(launch_context, process, lambda: _is_started(process), timeout)


async def wait_for_exit(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    timeout: float | None = None,
) -> bool:
    """Wait until a process has exited; return whether it has. See `wait_for_start`."""
    process = execute_process_action
    return await _wait(launch_context, process, lambda: _has_ended(process), timeout)


def wait_for_output_sync(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> object:
    """Wait as `wait_for_output` does, without an event loop."""
    process = execute_process_action
    return _wait_sync(
        launch_context, process, lambda: validate_output(process.get_stdout()), timeout
    )


def wait_for_stderr_sync(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> object:
    """Wait as `wait_for_stderr` does, without an event loop."""
    process = execute_process_action
    return _wait_sync(
        launch_context, process, lambda: validate_output(process.get_stderr()), timeout
    )


def assert_output_sync(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> None:
    """Wait as `assert_output` does, without an event loop."""
    written = execute_process_action.get_stdout
    condition = _holds(validate_output, written)
    if not _wait_sync(launch_context, execute_process_action, condition, timeout):
        validate_output(written())


def assert_stderr_sync(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    validate_output: Validate,
    timeout: float | None = None,
) -> None:
    """Wait as `assert_stderr` does, without an event loop."""
    written = execute_process_action.get_stderr
    condition = _holds(validate_output, written)
    if not _wait_sync(launch_context, execute_process_action, condition, timeout):
        validate_output(written())


def wait_for_start_sync(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    timeout: float | None = None,
) -> bool:
    """Wait as `wait_for_start` does, without an event loop."""
    process = execute_process_action
    return _wait_sync(launch_context, process, lambda: _is_started(process), timeout)


def wait_for_exit_sync(
    launch_context: LaunchContext,
    execute_process_action: ExecuteLocal,
    timeout: float | None = None,
) -> bool:
    """Wait as `wait_for_exit` does, without an event loop."""
    process = execute_process_action
    return _wait_sync(launch_context, process, lambda: _has_ended(process), timeout)


def _is_started(process: ExecuteLocal) -> bool:
    details = process.process_details
    return details is not None and "pid" in details


def _has_ended(process: ExecuteLocal) -> bool:
    return process.return_code is not None

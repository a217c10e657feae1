"""``launch_testing.tools.process``: process that a test starts in a running launch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteLocal
from launch.events import IncludeLaunchDescription, matches_action
from launch.events.process import ProcessExited, ProcessStarted, ShutdownProcess
from launch.utilities import ensure_argument_type

from ..io_handler import ActiveIoHandler
from ..proc_info_handler import ActiveProcInfoHandler


class ProcessProxy:
    """State and output of a process that a test has started.

    Args:
        process_action: The action that starts it.
        proc_info: Recorded events of the launch's processes.
        proc_output: Recorded output of the processes.
        output_filter: Function applied to the output before a check.

    Raises:
        TypeError: One of them is of another kind.
    """

    def __init__(
        self,
        process_action: ExecuteLocal,
        proc_info: ActiveProcInfoHandler,
        proc_output: ActiveIoHandler,
        *,
        output_filter: Callable[[str], str] | None = None,
    ) -> None:
        ensure_argument_type(process_action, ExecuteLocal, "process_action")
        ensure_argument_type(proc_info, ActiveProcInfoHandler, "proc_info")
        ensure_argument_type(proc_output, ActiveIoHandler, "proc_output")
        if output_filter is not None and not callable(output_filter):
            raise TypeError(f"Expected 'output_filter' to be callable but got '{output_filter!r}'")
        self._action = process_action
        self._info = proc_info
        self._output = proc_output
        self._filter = output_filter

    @property
    def target_process_action(self) -> ExecuteLocal:
        """Action that starts the process."""
        return self._action

    def wait_for_shutdown(self, timeout: float | None = None) -> bool:
        """Wait until the process has exited; return whether it has.

        Args:
            timeout: Seconds to wait; None for as long as it takes.
        """
        with self._info.proc_event:
            return self._info.proc_event.wait_for(lambda: self.terminated, timeout=timeout)

    def wait_for_output(
        self, condition: Callable[[str], object] | None = None, timeout: float | None = None
    ) -> OutputSeen:
        """Wait until the output of the process matches; return whether it does.

        Args:
            condition: Tells whether all that it has written is what one waits for; None for
                whatever it may be.
            timeout: Seconds to wait; None for as long as it takes.

        Raises:
            TypeError: The condition cannot be called.
        """
        if condition is not None and not callable(condition):
            raise TypeError(f"Expected 'condition' to be callable but got '{condition!r}'")
        seen: str | None = None

        def is_written() -> bool:
            nonlocal seen
            if not self.running:
                return False
            seen = self.output
            return condition is None or bool(condition(seen))

        with self._output.io_event:
            found = self._output.io_event.wait_for(is_written, timeout=timeout)
        return OutputSeen(found, seen)

    @property
    def stdout(self) -> str:
        """What it has written to stdout."""
        return self._text(lambda event: bool(event.from_stdout))

    @property
    def stderr(self) -> str:
        """What it has written to stderr."""
        return self._text(lambda event: bool(event.from_stderr))

    @property
    def output(self) -> str:
        """What it has written."""
        return self._text(lambda _: True)

    # Any: an event of what was written.
    def _text(self, is_meant: Callable[[Any], bool]) -> str:
        events = self._output[self._action]
        text = "".join(event.text.decode(errors="replace") for event in events if is_meant(event))
        return self._filter(text) if self._filter is not None else text

    @property
    def running(self) -> bool:
        """Whether the process has started and not exited."""
        return self._last_is(ProcessStarted)

    @property
    def terminated(self) -> bool:
        """Whether the process has exited."""
        return self._last_is(ProcessExited)

    def _last_is(self, event_class: type) -> bool:
        known = self._action in self._info.processes()
        return known and isinstance(self._info[self._action], event_class)

    @property
    def exit_code(self) -> int:
        """Exit code of the process.

        Raises:
            AttributeError: It has not ended.
            KeyError: It was never started.
        """
        event = self._info[self._action]
        if not isinstance(event, ProcessExited):
            raise AttributeError(f"{event.process_name} has not ended")
        return event.returncode


class OutputSeen:
    """Result of a wait for output, with the output instead of the expected one.

    Args:
        found: Whether it was.
        output: Output at the last check.
    """

    def __init__(self, found: bool, output: str | None) -> None:
        self._found = found
        self._output = output

    def __bool__(self) -> bool:
        return self._found

    def __repr__(self) -> str:
        return f"<OutputSeen({self._found}): {self._output!r}>"


# Any: arguments of `ProcessProxy.`
@contextmanager
def launch_process(
    launch_service: LaunchService,
    process_action: ExecuteLocal,
    proc_info: ActiveProcInfoHandler,
    proc_output: ActiveIoHandler,
    **kwargs: Any,
) -> Iterator[ProcessProxy]:
    """Start a process in a running launch, and shut it down at the end of the block.

    Args:
        launch_service: The launch.
        process_action: The action that starts it.
        proc_info: Recorded events of the launch's processes.
        proc_output: Recorded output of the processes.
        kwargs: Further arguments of `ProcessProxy`.
    """
    proxy = ProcessProxy(process_action, proc_info, proc_output, **kwargs)
    launch_service.emit_event(IncludeLaunchDescription(LaunchDescription([process_action])))
    try:
        yield proxy
    finally:
        if not proxy.terminated:
            launch_service.emit_event(
                ShutdownProcess(process_matcher=matches_action(process_action))
            )

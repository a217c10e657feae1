"""``launch_testing.proc_info_handler``: recorded starts and exits of processes."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, KeysView
from typing import Any

from launch.actions import ExecuteLocal
from launch.events.process import ProcessExited, RunningProcessEvent

from .util import NoMatchingProcessException, resolveProcesses


class ProcInfoHandler:
    """Last event of each process: its start or its exit."""

    def __init__(self) -> None:
        # By the actions of processes. Any: several classes of actions.
        self._last: dict[Any, RunningProcessEvent] = {}

    def append(self, process_info: RunningProcessEvent) -> None:
        """Record an event."""
        self._last[process_info.action] = process_info

    def __iter__(self) -> Iterator[RunningProcessEvent]:
        return iter(self._last.values())

    def processes(self) -> KeysView[ExecuteLocal]:
        """Return the actions of the processes."""
        return self._last.keys()

    def process_names(self) -> list[str]:
        """Return the names of the processes."""
        return [event.process_name for event in self._last.values()]

    def __getitem__(self, key: str | ExecuteLocal) -> RunningProcessEvent:
        """Return the last event of a process, by its action or a part of its name."""
        if not isinstance(key, str):
            return self._last[key]
        for event in self._last.values():
            if key in event.process_name:
                return event
        raise KeyError(key)


class ActiveProcInfoHandler:
    """Thread-safe `ProcInfoHandler` on which tests can wait."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._handler = ProcInfoHandler()

    @property
    def proc_event(self) -> threading.Condition:
        """Condition that is notified at each event."""
        return self._changed

    @property
    def proc_info_handler(self) -> ProcInfoHandler:
        """The wrapped `ProcInfoHandler`, without lock."""
        return self._handler

    def append(self, process_info: RunningProcessEvent) -> None:
        """Record an event."""
        with self._changed:
            self._handler.append(process_info)
            self._changed.notify_all()

    def __iter__(self) -> Iterator[RunningProcessEvent]:
        with self._changed:
            return iter(list(self._handler))

    def processes(self) -> list[ExecuteLocal]:
        """Return the actions of the processes."""
        with self._changed:
            return list(self._handler.processes())

    def process_names(self) -> list[str]:
        """Return the names of the processes."""
        with self._changed:
            return self._handler.process_names()

    def __getitem__(self, key: str | ExecuteLocal) -> RunningProcessEvent:
        """Return the last event of a process, by its action or a part of its name."""
        with self._changed:
            return self._handler[key]

    def assertWaitForShutdown(  # noqa: N802 -- the original's name
        self,
        process: ExecuteLocal | str | None,
        cmd_args: Iterable[str] | str | object | None = None,
        *,
        timeout: float | None = 10,
    ) -> None:
        """Assert that a process exits within a timeout.

        Args:
            process: Its action, or a part of its name.
            cmd_args: Arguments that it was started with.
            timeout: Seconds to wait.

        Raises:
            AssertionError: It has not ended by then.
        """
        self._wait(process, cmd_args, timeout, "finish", ProcessExited)

    def assertWaitForStartup(  # noqa: N802 -- the original's name
        self,
        process: ExecuteLocal | str | None,
        cmd_args: Iterable[str] | str | object | None = None,
        *,
        timeout: float | None = 10,
    ) -> None:
        """Assert that a process starts within a timeout.

        Args:
            process: Its action, or a part of its name.
            cmd_args: Arguments that it was started with.
            timeout: Seconds to wait.

        Raises:
            AssertionError: It has not been started by then.
        """
        self._wait(process, cmd_args, timeout, "start", RunningProcessEvent)

    def _wait(
        self,
        process: ExecuteLocal | str | None,
        arguments: Iterable[str] | str | object | None,
        timeout: float | None,
        what: str,
        event_class: type[RunningProcessEvent],
    ) -> None:
        def has_come() -> bool:
            try:
                found = resolveProcesses(self._handler, process=process, cmd_args=arguments)
            except NoMatchingProcessException:
                return False
            return isinstance(self._handler[found[0]], event_class)

        with self._changed:
            has_happened = self._changed.wait_for(has_come, timeout=timeout)
        assert has_happened, f"Timed out waiting for process '{process}' to {what}"

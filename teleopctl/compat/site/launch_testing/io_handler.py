"""``launch_testing.io_handler``: recorded output of processes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, KeysView
from typing import Any

from launch.actions import ExecuteLocal
from launch.events.process import ProcessIO

from .asserts.assert_output import assertInStream
from .util import NoMatchingProcessException, resolveProcesses


class IoHandler:
    """Recorded output of processes, in order of arrival."""

    def __init__(self) -> None:
        self._all: list[ProcessIO] = []
        self._by_name: dict[str, list[ProcessIO]] = {}

    def track(self, process_name: str) -> None:
        """Add a process without output."""
        self._by_name.setdefault(process_name, [])

    def append(self, process_io: ProcessIO) -> None:
        """Append output of a process."""
        self._all.append(process_io)
        self._by_name.setdefault(process_io.process_name, []).append(process_io)

    def __iter__(self) -> Iterator[ProcessIO]:
        return iter(self._all)

    # Any: the actions are those of the events.
    def processes(self) -> list[Any]:
        """Return the actions of the recorded processes."""
        return [events[0].action for events in self._by_name.values() if events]

    def process_names(self) -> KeysView[str]:
        """Return the names of the processes."""
        return self._by_name.keys()

    def __getitem__(self, key: str | ExecuteLocal) -> list[ProcessIO]:
        """Return the output of a process, by its action or name."""
        if isinstance(key, str):
            return list(self._by_name[key])
        details = key.process_details
        if details is None:
            raise KeyError(key)
        return list(self._by_name[details["name"]])


class ActiveIoHandler:
    """Thread-safe `IoHandler` on which tests can wait."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._handler = IoHandler()

    @property
    def io_event(self) -> threading.Condition:
        """Condition that is notified at each output."""
        return self._changed

    @property
    def io_handler(self) -> IoHandler:
        """The wrapped `IoHandler`, without lock."""
        return self._handler

    def track(self, process_name: str) -> None:
        """Add a process without output."""
        with self._changed:
            self._handler.track(process_name)
            self._changed.notify_all()

    def append(self, process_io: ProcessIO) -> None:
        """Append output of a process."""
        with self._changed:
            self._handler.append(process_io)
            self._changed.notify_all()

    def __iter__(self) -> Iterator[ProcessIO]:
        with self._changed:
            return iter(list(self._handler))

    # Any: the actions are those of the events.
    def processes(self) -> list[Any]:
        """Return the actions of the recorded processes."""
        with self._changed:
            return self._handler.processes()

    def process_names(self) -> list[str]:
        """Return the names of the processes."""
        with self._changed:
            return list(self._handler.process_names())

    def __getitem__(self, key: str | ExecuteLocal) -> list[ProcessIO]:
        """Return the output of a process, by its action or name."""
        with self._changed:
            return self._handler[key]

    # Any: arguments of `waitFor`.
    def assertWaitFor(self, *args: Any, **kwargs: Any) -> None:  # noqa: N802 -- the original's name
        """Assert that an output appears within a timeout; see `waitFor`.

        Raises:
            AssertionError: The output did not appear in time.
        """
        assert self.waitFor(*args, **kwargs), "Waiting for output timed out"

    # Any: texts and patterns, as `build_text_match` takes them.
    def waitFor(  # noqa: N802 -- the original's name
        self,
        expected_output: Any,
        process: ExecuteLocal | str | None = None,
        cmd_args: Iterable[str] | str | object | None = None,
        *,
        strict_proc_matching: bool = True,
        output_filter: Callable[[str], str] | None = None,
        timeout: float | None = 10,
        strip_ansi_escape_sequences: bool = True,
        stream: str = "stderr",
    ) -> bool:
        """Wait until an output appears; return whether it did.

        Args:
            expected_output: A text, a pattern, or several of them in their order.
            process: Its action, a part of its name, or None for any process.
            cmd_args: Arguments that it was started with.
            strict_proc_matching: Whether a name may mean one process only.
            output_filter: Function applied to the output before.
            timeout: Seconds to wait.
            strip_ansi_escape_sequences: Whether colours do not count.
            stream: ``stderr`` or ``stdout``.

        Raises:
            RuntimeError: No such process has written anything.
        """

        def is_written() -> bool:
            try:
                assertInStream(
                    self._handler,
                    expected_output,
                    process,
                    cmd_args,
                    output_filter=output_filter,
                    strict_proc_matching=strict_proc_matching,
                    strip_ansi_escape_sequences=strip_ansi_escape_sequences,
                    stream=stream,
                )
            except (AssertionError, NoMatchingProcessException):
                return False
            return True

        with self._changed:
            if self._changed.wait_for(is_written, timeout=timeout):
                return True
        try:
            resolveProcesses(self, process=process, cmd_args=cmd_args, strict_proc_matching=False)
        except NoMatchingProcessException as error:
            raise RuntimeError(
                f"Timed out, and nothing was written by any process that matches '{process}': it "
                f"does not exist, was never launched, or writes nothing. {error}"
            ) from error
        return False

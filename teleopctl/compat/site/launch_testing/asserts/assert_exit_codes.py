"""``launch_testing.asserts.assert_exit_codes``."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol

from launch.events.process import ProcessExited

from ..util.proc_lookup import KnowsProcesses, resolveProcesses

if TYPE_CHECKING:
    from launch.actions import ExecuteLocal
    from launch.events.process import RunningProcessEvent

    class KnowsEvents(KnowsProcesses, Protocol):
        """Protocol of objects with the last event of each process."""

        def __getitem__(self, key: ExecuteLocal, /) -> RunningProcessEvent: ...


EXIT_OK = 0
EXIT_SIGINT = 130
EXIT_SIGQUIT = 131
EXIT_SIGKILL = 137
EXIT_SIGSEGV = 139
# Exit code of a process that is terminated on Windows.
EXIT_FORCED = 1

_FINE = (EXIT_OK, EXIT_FORCED) if os.name == "nt" else (EXIT_OK,)


def assertExitCodes(  # noqa: N802 -- the original's name
    proc_info: KnowsEvents,
    allowable_exit_codes: Iterable[int] = _FINE,
    process: ExecuteLocal | str | None = None,
    cmd_args: Iterable[str] | str | object | None = None,
    *,
    strict_proc_matching: bool = True,
) -> None:
    """Assert that processes have exited with permitted exit codes.

    Args:
        proc_info: Recorded events of the processes.
        allowable_exit_codes: Exit statuses that are right.
        process: An action, a part of a process's name, or None for all processes.
        cmd_args: Arguments that it was started with.
        strict_proc_matching: Whether a name may mean one process only.

    Raises:
        AssertionError: One has ended with another status, or not at all.
        NoMatchingProcessException: There is no such process.
    """
    allowed = list(allowable_exit_codes)
    for code in allowed:
        assert isinstance(code, int), f"Provided exit code {code} is not an int"
    for action in resolveProcesses(
        proc_info, process=process, cmd_args=cmd_args, strict_proc_matching=strict_proc_matching
    ):
        event = proc_info[action]
        assert isinstance(event, ProcessExited), f"Proc {event.process_name} has not exited"
        assert event.returncode in allowed, (
            f"Proc {event.process_name} exited with code {event.returncode}"
        )

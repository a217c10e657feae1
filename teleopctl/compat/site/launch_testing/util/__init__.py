"""``launch_testing.util``."""

import sys

from launch.actions import ExecuteProcess

from .proc_lookup import NO_CMD_ARGS, NoMatchingProcessException, resolveProcesses

_WAITS = "import threading\ntry:\n    threading.Event().wait()\nexcept KeyboardInterrupt:\n    pass"


def KeepAliveProc() -> ExecuteProcess:  # noqa: N802 -- the original's name
    """Return a process that runs until it is interrupted, so that the launch goes on."""
    return ExecuteProcess(cmd=[sys.executable, "-c", _WAITS])


__all__ = ["NO_CMD_ARGS", "KeepAliveProc", "NoMatchingProcessException", "resolveProcesses"]

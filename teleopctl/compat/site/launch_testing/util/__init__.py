"""``launch_testing.util``."""

import sys

from launch.actions import ExecuteProcess

from .proc_lookup import NO_CMD_ARGS, NoMatchingProcessException, resolveProcesses

_WAITS = """
import time
try:
    while True:
        time.sleep(60)
except KeyboardInterrupt:
    pass
"""


def KeepAliveProc() -> ExecuteProcess:  # noqa: N802 -- the original's name
    """Return a process that runs until it is interrupted, so that the launch does not end."""
    # Without `site` it starts in half the time; an interrupt during the start would be a failure.
    return ExecuteProcess(cmd=[sys.executable, "-S", "-c", _WAITS])


__all__ = ["NO_CMD_ARGS", "KeepAliveProc", "NoMatchingProcessException", "resolveProcesses"]

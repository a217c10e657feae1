"""Ends a command by becoming another program."""

from __future__ import annotations

import os
import sys

from teleopctl.errors import SystemFailureError


def replace_this_process(command: list[str]) -> int:
    """Replace this process by a command.

    Returns:
        The exit status, on Windows only.

    Raises:
        SystemFailureError: It cannot be started.
    """
    sys.stdout.flush()
    try:
        if os.name == "nt":
            return _wait_for(command)
        os.execvp(command[0], command)  # noqa: S606 -- the user's own command
    except OSError as error:
        raise SystemFailureError(f"Cannot run {command[0]}: {error.strerror}") from error


def _wait_for(command: list[str]) -> int:
    """Run a command; Windows has no exec: a process that calls it ends before the program does."""
    import signal
    import subprocess

    # Ctrl-C reaches both processes, and only the command knows what to do then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return subprocess.run(command, check=False).returncode

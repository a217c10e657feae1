"""Ends what tests have left running, and removes their folder, however the tests end.

A process of its own, which waits for the end of the one that runs the tests: killed, timed out or
in order. Whatever has the folder in its environment was started there.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

# A process that is killed may just have started another one.
_LOOKS = 5


def watch_over(folder: Path) -> subprocess.Popen[bytes]:
    """Start a reaper for this process; closing its standard input has it do its work now."""
    return subprocess.Popen(
        [sys.executable, "-I", __file__, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        # Ctrl-C and the end of the terminal are for the tests.
        start_new_session=True,
    )


def _reap(folder: str, tester: int) -> None:
    # Not needed while the tests run.
    import psutil

    spared = {os.getpid(), tester}
    for _ in range(_LOOKS):
        left = []
        for process in psutil.process_iter():
            with contextlib.suppress(psutil.Error, OSError):
                if process.pid in spared or not _is_of(process.environ(), folder):
                    continue
                process.kill()
                left.append(process)
        if not left:
            break
        psutil.wait_procs(left, timeout=0.2)
    shutil.rmtree(folder, ignore_errors=True)


def _is_of(environment: dict[str, str], folder: str) -> bool:
    return any(value.startswith(folder) for value in environment.values())


if __name__ == "__main__":
    tester = os.getppid()
    sys.stdin.buffer.read()
    _reap(sys.argv[1], tester)

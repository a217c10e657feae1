"""Process that kills processes left running by tests, and removes the tests' folder.

The reaper waits for the end of the process that runs the tests, whether regular, killed or timed
out. Processes of the tests are found by the folder in their environment variables.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

# Number of searches: a killed process may have started another process just before.
_LOOKS = 5
# Environment variables without which Python does not start on Windows.
_NEEDED = ("PATH", "SYSTEMROOT")


def watch_over(folder: Path) -> subprocess.Popen[bytes]:
    """Start a reaper for this process and return it; the reaper acts when its stdin is closed."""
    return subprocess.Popen(
        [sys.executable, "-I", __file__, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        # Without the folder of the main process, whose reaper would end the reapers of its workers.
        env={name: os.environ[name] for name in _NEEDED if name in os.environ},
        # Ctrl-C and the end of the terminal must not end the reaper.
        start_new_session=True,
    )


def _reap(folder: str, tester: int) -> None:
    # Imported only here: not needed while the tests run.
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

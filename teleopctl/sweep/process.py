"""Child processes of runs, one for each run, ended with all that they have started."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

from teleopctl.base import background
from teleopctl.base.files import open_private
from teleopctl.errors import SystemFailureError
from teleopctl.sweep.one_run import (
    BAG,
    RESULT_FILE,
    RUNTIME,
    RunRequest,
    RunResult,
    environment,
    load_result,
)

LOG_FILE = "run.log"
# Option after the folder on the command line of a run's process.
GUARDED = "--guarded"


class RunProcesses:
    """Child processes that execute the runs of a sweep; its methods are thread-safe.

    Args:
        guarded: Whether the child processes end when this process ends, even if it is killed.
    """

    def __init__(self, *, guarded: bool = False) -> None:
        self._guarded = guarded
        self._lock = threading.Lock()
        self._at_work: set[subprocess.Popen[bytes]] = set()
        self._stopped = False

    def stop(self) -> None:
        """Interrupt the running child processes, and prevent further runs from starting."""
        with self._lock:
            self._stopped = True
            for process in self._at_work:
                # On Windows an interrupt does not reach a process of another console.
                process.send_signal(signal.SIGTERM if os.name == "nt" else signal.SIGINT)

    def run(
        self,
        request: RunRequest,
        folder: Path,
        domain_index: int,
        port: int,
        cwd: Path | None = None,
    ) -> RunResult | None:
        """Execute a run in a child process and wait; return its result, or None after `stop`.

        Args:
            request: Request of the run.
            folder: Folder of the run, which already contains the request.
            domain_index: See `environment`.
            port: See `environment`.
            cwd: Working directory of the child process; None for the current one.
        """
        started = time.monotonic()
        try:
            status = self._run(folder, domain_index, port, cwd)
            how = f"killed by signal {-status}" if status < 0 else f"exit status {status}"
            ending = f"its process ended without a result ({how})"
        except OSError as error:
            ending = str(error)
        result = load_result(folder)
        if result is None and not self._stopped:
            reason = f"{ending}, see {folder / LOG_FILE}"
            result = failed_result(request, folder, reason, time.monotonic() - started)
            with contextlib.suppress(OSError):
                result.save()
        return None if self._stopped else result

    def _run(self, folder: Path, domain_index: int, port: int, cwd: Path | None) -> int:
        """Execute a run in a child process, and return the exit status of the process."""
        clear_run(folder)
        with open(folder / LOG_FILE, "wb", opener=open_private) as log:
            with self._lock:
                if self._stopped:
                    return 0
                process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "teleopctl.sweep", str(folder)]
                    + ([GUARDED] if self._guarded else []),
                    env=dict(environment(folder, domain_index, port)),
                    cwd=cwd,
                    # The pipe carries no data; it closes when this process ends.
                    stdin=subprocess.PIPE if self._guarded else subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    # Ctrl-C goes to the sweep only, which then stops its runs.
                    start_new_session=True,
                )
                self._at_work.add(process)
            status = process.wait()
            with self._lock:
                self._at_work.discard(process)
            if process.stdin is not None:
                process.stdin.close()
        # A killed process could not stop its own child processes.
        for record in background.records(folder / RUNTIME):
            # A process that survives SIGKILL must not end the sweep.
            with contextlib.suppress(SystemFailureError):
                background.stop(record)
        shutil.rmtree(folder / RUNTIME, ignore_errors=True)
        return status


def failed_result(request: RunRequest, folder: Path, error: str, wall_s: float = 0.0) -> RunResult:
    """Return a `RunResult` with ``failed`` and an error, for a run that left no result itself."""
    return RunResult(
        number=request.number,
        parameters=request.parameters,
        result="failed",
        error=error,
        wall_s=wall_s,
        simulated_s=None,
        measures=dict.fromkeys(request.measures),
        folder=str(folder),
    )


def clear_run(folder: Path) -> None:
    """Remove bag, logs, result and process records that an earlier try left in a run's folder."""
    for name in (BAG, "log", RUNTIME):
        shutil.rmtree(folder / name, ignore_errors=True)
    for name in (RESULT_FILE, LOG_FILE):
        (folder / name).unlink(missing_ok=True)


def free_ports(count: int) -> list[int]:
    """Return ``count`` different free TCP ports of the loopback interface."""
    with contextlib.ExitStack() as sockets:
        found = [sockets.enter_context(socket.socket()) for _ in range(count)]
        for each in found:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in found]

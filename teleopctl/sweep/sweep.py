"""Many runs of a launch file beside one another, each with its folder."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from teleopctl import background
from teleopctl.errors import InvalidFileError, NotFoundError, RefusedError
from teleopctl.sweep.one_run import (
    BAG,
    RESULT_FILE,
    RUNTIME,
    RunRequest,
    RunResult,
    environment,
    load_result,
    load_run,
)

SWEEP_FILE = "sweep.json"
LOG_FILE = "run.log"


class Sweep:
    """The runs of a sweep, in a folder.

    Args:
        folder: Theirs; each run has one below it, by its number.
        requests: What each is to be.
    """

    def __init__(self, folder: Path, requests: Sequence[RunRequest]) -> None:
        self.folder = folder
        self.requests = list(requests)
        # What this process has seen, also where there was no room to write it down.
        self._seen: dict[int, RunResult] = {}

    @classmethod
    def create(
        cls, folder: Path, requests: Sequence[RunRequest], asked: Mapping[str, object]
    ) -> Sweep:
        """Make the folder, and those of the runs.

        Args:
            folder: Where there is nothing yet.
            requests: What each run is to be.
            asked: What was asked for, to be kept beside the runs, as JSON.

        Raises:
            RefusedError: There is something already.
        """
        if folder.exists() and any(folder.iterdir()):
            raise RefusedError(
                f"Output folder '{folder}' already exists.",
                hint="Name another one, remove it, or go on there with --resume.",
            )
        sweep = cls(folder, requests)
        for request in requests:
            path = sweep.folder_of(request)
            path.mkdir(parents=True)
            request.save(path)
        (folder / SWEEP_FILE).write_text(json.dumps(asked, indent=1), encoding="utf-8")
        return sweep

    @classmethod
    def open(cls, folder: Path) -> Sweep:
        """Find the runs of a sweep that was begun.

        Raises:
            NotFoundError: There is none in that folder.
            InvalidFileError: A file of it is broken.
        """
        if not (folder / SWEEP_FILE).is_file():
            raise NotFoundError(f"There is no sweep in '{folder}': it has no {SWEEP_FILE}")
        try:
            runs = [load_run(path) for path in sorted(folder.iterdir()) if path.name.isdecimal()]
        except (OSError, ValueError, TypeError) as error:
            raise InvalidFileError(f"{folder}: a run cannot be read: {error}") from error
        return cls(folder, sorted(runs, key=lambda request: request.number))

    def folder_of(self, request: RunRequest) -> Path:
        """The folder of a run."""
        width = max(3, len(str(len(self.requests))))
        return self.folder / f"{request.number:0{width}d}"

    def results(self) -> list[RunResult]:
        """What came of those runs that have come to their end, in their order."""
        found = [
            load_result(self.folder_of(request)) or self._seen.get(request.number)
            for request in self.requests
        ]
        return [result for result in found if result is not None]

    def run(
        self, jobs: int, on_begin: Callable[[], None], on_result: Callable[[RunResult], None]
    ) -> None:
        """Do the runs that are not done yet, those that failed once more.

        Args:
            jobs: How many at a time.
            on_begin: Called when one begins.
            on_result: Called with what came of each.

        Raises:
            KeyboardInterrupt: Ctrl-C; the runs at work have been stopped, what is done is kept.
        """
        left: queue.SimpleQueue[RunRequest] = queue.SimpleQueue()
        for request in self.requests:
            result = load_result(self.folder_of(request))
            if result is None or not result.is_done:
                left.put(request)
        count = left.qsize()
        crew = _Crew(self, left)
        slots = [
            threading.Thread(target=crew.work, args=(slot, port), daemon=True)
            for slot, port in enumerate(free_ports(min(jobs, count)))
        ]
        for thread in slots:
            thread.start()
        try:
            while count:
                result = crew.told.get()
                if result is None:
                    on_begin()
                    continue
                self._seen[result.number] = result
                on_result(result)
                count -= 1
        except BaseException:
            crew.stop()
            raise
        finally:
            for thread in slots:
                thread.join()


class _Crew:
    """Those who do the runs, each one after another; told: None when one begins, then its result.

    Args:
        sweep: Whose runs.
        left: What is to be done.
    """

    def __init__(self, sweep: Sweep, left: queue.SimpleQueue[RunRequest]) -> None:
        self._sweep = sweep
        self._left = left
        self.told: queue.SimpleQueue[RunResult | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._at_work: set[subprocess.Popen[bytes]] = set()
        self._stopped = False

    def stop(self) -> None:
        """End the runs at work, and begin no other."""
        with self._lock:
            self._stopped = True
            for process in self._at_work:
                # Windows has no interrupt that reaches a process without a common console.
                process.send_signal(signal.SIGTERM if os.name == "nt" else signal.SIGINT)

    def work(self, slot: int, port: int) -> None:
        """Do one run after another until none is left."""
        while not self._stopped:
            try:
                request = self._left.get_nowait()
            except queue.Empty:
                return
            self.told.put(None)
            folder, started = self._sweep.folder_of(request), time.monotonic()
            try:
                status = self._do(folder, slot, port)
                how = f"killed by signal {-status}" if status < 0 else f"exit status {status}"
                ending = f"its process ended without a result ({how})"
            except OSError as error:
                ending = str(error)
            result = load_result(folder)
            if result is None and not self._stopped:
                result = _without_result(request, folder, ending, time.monotonic() - started)
                with contextlib.suppress(OSError):
                    result.save()
            if result is not None and not self._stopped:
                self.told.put(result)

    def _do(self, folder: Path, slot: int, port: int) -> int:
        """Do a run; returns how its process ended."""
        _clear(folder)
        with (folder / LOG_FILE).open("wb") as log:
            with self._lock:
                if self._stopped:
                    return 0
                process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "teleopctl.sweep", str(folder)],
                    env=dict(environment(folder, slot, port)),
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    # Ctrl-C is for the sweep, which stops its runs.
                    start_new_session=True,
                )
                self._at_work.add(process)
            status = process.wait()
            with self._lock:
                self._at_work.discard(process)
        # A process that was killed could not end what it had started.
        for record in background.records(folder / RUNTIME):
            background.stop(record)
        shutil.rmtree(folder / RUNTIME, ignore_errors=True)
        return status


def _without_result(request: RunRequest, folder: Path, ending: str, wall_s: float) -> RunResult:
    return RunResult(
        number=request.number,
        parameters=request.parameters,
        result="failed",
        error=f"{ending}, see {folder / LOG_FILE}",
        wall_s=wall_s,
        simulated_s=None,
        measures=dict.fromkeys(request.measures),
        folder=str(folder),
    )


def _clear(folder: Path) -> None:
    """Remove what is left of a run that was stopped or has failed."""
    for name in (BAG, "log", RUNTIME):
        shutil.rmtree(folder / name, ignore_errors=True)
    for name in (RESULT_FILE, LOG_FILE):
        (folder / name).unlink(missing_ok=True)


def free_ports(count: int) -> list[int]:
    """Ports of the loopback interface that nobody has, no two the same."""
    with contextlib.ExitStack() as sockets:
        found = [sockets.enter_context(socket.socket()) for _ in range(count)]
        for each in found:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in found]

"""Sweep: many runs of a launch file in parallel, each with its folder."""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from teleopctl.errors import InvalidFileError, NotFoundError, RefusedError
from teleopctl.sweep.one_run import RunRequest, RunResult, load_request, load_result
from teleopctl.sweep.process import RunProcesses, free_ports

SWEEP_FILE = "sweep.json"


class Sweep:
    """Many runs of a launch file, with requests, results and bags in numbered folders.

    Args:
        folder: Folder of the sweep, with a numbered subfolder for each run.
        requests: Requests of the runs.
    """

    def __init__(self, folder: Path, requests: Sequence[RunRequest]) -> None:
        self.folder = folder
        self.requests = list(requests)
        # Results of this process by run number, also those that could not be written to disk.
        self._seen: dict[int, RunResult] = {}

    @classmethod
    def create(
        cls, folder: Path, requests: Sequence[RunRequest], options: Mapping[str, object]
    ) -> Sweep:
        """Create and return a sweep: write its options, and each run's request into a folder.

        Args:
            folder: New or empty folder.
            requests: Requests of the runs.
            options: Options of the command, written to ``sweep.json``.

        Raises:
            RefusedError: The folder is not empty.
        """
        if folder.exists() and any(folder.iterdir()):
            raise RefusedError(
                f"Output folder '{folder}' already exists.",
                hint="Choose another folder, remove this one, or continue with --resume.",
            )
        sweep = cls(folder, requests)
        for request in requests:
            path = sweep.folder_of(request)
            path.mkdir(parents=True)
            request.save(path)
        (folder / SWEEP_FILE).write_text(json.dumps(options, indent=1), encoding="utf-8")
        return sweep

    @classmethod
    def open(cls, folder: Path) -> Sweep:
        """Return the sweep that a folder contains, with the requests read from its runs' folders.

        Raises:
            NotFoundError: The folder contains no sweep.
            InvalidFileError: The request of a run cannot be read.
        """
        if not (folder / SWEEP_FILE).is_file():
            raise NotFoundError(f"There is no sweep in '{folder}': it has no {SWEEP_FILE}")
        try:
            runs = [
                load_request(path) for path in sorted(folder.iterdir()) if path.name.isdecimal()
            ]
        except (OSError, ValueError, TypeError) as error:
            raise InvalidFileError(f"{folder}: a run cannot be read: {error}") from error
        return cls(folder, sorted(runs, key=lambda request: request.number))

    def folder_of(self, request: RunRequest) -> Path:
        """Return the folder of a run, named by the run's number, such as ``007``."""
        width = max(3, len(str(len(self.requests))))
        return self.folder / f"{request.number:0{width}d}"

    def results(self) -> list[RunResult]:
        """Return the results of all runs that have one, failed ones included, in order of runs."""
        found = [
            load_result(self.folder_of(request)) or self._seen.get(request.number)
            for request in self.requests
        ]
        return [result for result in found if result is not None]

    def pending(self) -> list[RunRequest]:
        """Return the requests of all runs that have no result yet or have failed."""
        found = ((request, load_result(self.folder_of(request))) for request in self.requests)
        return [request for request, result in found if result is None or not result.is_done]

    def add_result(self, result: RunResult) -> None:
        """Keep a run's result in memory, so that `results` has it even without its file."""
        self._seen[result.number] = result

    def run(
        self, jobs: int, on_begin: Callable[[], None], on_result: Callable[[RunResult], None]
    ) -> None:
        """Execute pending runs, ``jobs`` at a time; call ``on_begin`` and ``on_result`` for each.

        Args:
            jobs: Number of runs at a time.
            on_begin: Called when a run begins.
            on_result: Called with the result of each run.

        Raises:
            KeyboardInterrupt: Ctrl-C; running runs have been stopped, finished runs are kept.
        """
        left: queue.SimpleQueue[RunRequest] = queue.SimpleQueue()
        for request in self.pending():
            left.put(request)
        count = left.qsize()
        threads = _RunThreads(self, left)
        slots = [
            threading.Thread(target=threads.work, args=(domain_index, port), daemon=True)
            for domain_index, port in enumerate(free_ports(min(jobs, count)))
        ]
        for thread in slots:
            thread.start()
        try:
            while count:
                result = threads.events.get()
                if result is None:
                    on_begin()
                    continue
                self.add_result(result)
                on_result(result)
                count -= 1
        except BaseException:
            threads.stop()
            raise
        finally:
            for thread in slots:
                thread.join()


class _RunThreads:
    """Threads that execute runs; put None into ``events`` when one begins, then its result.

    Args:
        sweep: Sweep of the runs.
        left: Queue of the pending requests.
    """

    def __init__(self, sweep: Sweep, left: queue.SimpleQueue[RunRequest]) -> None:
        self._sweep = sweep
        self._left = left
        self.events: queue.SimpleQueue[RunResult | None] = queue.SimpleQueue()
        self._processes = RunProcesses()
        self._stopped = False

    def stop(self) -> None:
        """Interrupt the running child processes, and prevent further runs from starting."""
        self._stopped = True
        self._processes.stop()

    def work(self, domain_index: int, port: int) -> None:
        """Execute pending runs until none is left; put None, then the result, into ``events``."""
        while not self._stopped:
            try:
                request = self._left.get_nowait()
            except queue.Empty:
                return
            self.events.put(None)
            folder = self._sweep.folder_of(request)
            result = self._processes.run(request, folder, domain_index, port)
            if result is not None:
                self.events.put(result)

"""Execution of a sweep by the workers of a Dask cluster."""

from __future__ import annotations

import contextlib
import queue
import uuid
import warnings
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from teleopctl.base.extras import extra
from teleopctl.errors import RefusedError, UnavailableError
from teleopctl.sweep.cluster.file_transfer import SentFolder, unpack
from teleopctl.sweep.cluster.worker import remove_sweep, run_on_worker, stop_runs, versions
from teleopctl.sweep.one_run import RunRequest, RunResult
from teleopctl.sweep.process import clear_run, failed_result
from teleopctl.sweep.sweep import Sweep

_CONNECTS_WITHIN_S = 10.0
# Period of checks of the connection to the scheduler, and longest interruption before an error.
_LOOK_EVERY_S = 1.0
_RETURNS_WITHIN_S = 30.0


class Cluster:
    """Connection to a Dask scheduler, whose workers execute the runs of a sweep.

    Use it as a context manager, which closes the connection.

    Args:
        address: Address of the scheduler, such as ``tcp://server:8786``.

    Attributes:
        slots: Number of runs executed at the same time.
        workers: Number of workers.

    Raises:
        MissingExtraError: Dask is not installed.
        UnavailableError: No scheduler responds at the address, or the scheduler has no workers.
        RefusedError: A worker lacks teleopctl or MuJoCo, or has another version of one of them.
    """

    def __init__(self, address: str) -> None:
        with extra("cluster", "distributed", "dask"):
            import distributed
        # Any: Dask's classes are not typed.
        connect: Any = distributed.Client
        try:
            self._client = connect(address, timeout=_CONNECTS_WITHIN_S, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise UnavailableError(
                f"No Dask scheduler answers at {address}",
                hint="Start one with `dask scheduler`, and `dask worker ADDRESS` on each machine.",
            ) from error
        try:
            threads = self._client.nthreads()
            if not threads:
                raise UnavailableError(
                    f"The Dask scheduler at {address} has no workers",
                    hint=f"Start one on each machine: dask worker {address}",
                )
            self._check()
        except BaseException:
            self._client.close()
            raise
        self.workers, self.slots = len(threads), sum(threads.values())

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def _check(self) -> None:
        """Raise if a worker lacks teleopctl or MuJoCo, or has another version of one of them."""
        ours = versions()
        theirs = self._client.run(versions, on_error="return")
        for worker, found in theirs.items():
            if isinstance(found, Exception):
                raise RefusedError(
                    f"The worker {worker} cannot execute runs: {found}",
                    hint="Install teleopctl[cluster] on its machine, in the same version.",
                )
            for name, version in ours.items():
                if found[name] != version:
                    raise RefusedError(
                        f"The worker {worker} has {name} {found[name]}, and this machine {version}",
                        hint="Install the same version on all machines.",
                    )

    def run(
        self,
        sweep: Sweep,
        sent_folder: SentFolder,
        archive: bytes,
        on_begin: Callable[[], None],
        on_result: Callable[[RunResult], None],
    ) -> None:
        """Execute a sweep's pending runs on the workers, which unpack ``archive``; store results.

        The output of each run is stored in the run's folder on this machine, as after a local run.
        Runs of a lost worker are repeated on other workers.

        Args:
            sweep: Sweep whose pending runs are executed.
            sent_folder: Folder that the runs need.
            archive: Content of the folder, as the bytes of a tar archive.
            on_begin: Called when a run begins.
            on_result: Called with the result of each run.

        Raises:
            UnavailableError: The connection to the scheduler is lost.
            KeyboardInterrupt: Ctrl-C; running runs have been stopped, finished runs are kept.
        """
        name = uuid.uuid4().hex
        # Events: the number of a run that begins, or the future of a run that has ended.
        events: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._client.subscribe_topic(name, lambda event: events.put(event[1]))
        # A task, since Dask recomputes its result when all workers that hold it are lost.
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph")
            sent = self._client.submit(bytes, archive, key=f"{name}-sent", pure=False)
        requests: dict[Any, RunRequest] = {}
        for request in sweep.pending():
            future = self._client.submit(
                run_on_worker, asdict(request), sent_folder, sent, name,
                key=f"{name}-{request.number}", pure=False,
            )  # fmt: skip
            requests[future] = request
            future.add_done_callback(events.put)
        begun: set[int] = set()
        try:
            for each in self._worker_events(events, len(requests)):
                if isinstance(each, int):
                    if each not in begun:
                        begun.add(each)
                        on_begin()
                    continue
                request = requests.pop(each)
                if request.number not in begun:
                    # The event of its end arrived before that of its start.
                    begun.add(request.number)
                    on_begin()
                result = _received(each, request, sweep.folder_of(request))
                sweep.add_result(result)
                on_result(result)
                each.release()
            with contextlib.suppress(Exception):
                self._client.run(remove_sweep, name)
        except BaseException:
            with contextlib.suppress(Exception):
                self._client.cancel(list(requests))
                self._client.run(stop_runs, name)
            raise

    def _worker_events(self, events: queue.SimpleQueue[Any], count: int) -> Iterator[Any]:
        """Yield events of the workers until that many runs have ended."""
        away_s = 0.0
        while count:
            try:
                each = events.get(timeout=_LOOK_EVERY_S)
            except queue.Empty:
                away_s = 0.0 if self._client.status == "running" else away_s + _LOOK_EVERY_S
                if away_s >= _RETURNS_WITHIN_S or self._client.status == "closed":
                    raise UnavailableError("The Dask scheduler has disappeared") from None
                continue
            count -= not isinstance(each, int)
            yield each


# Any: a future of Dask.
def _received(future: Any, request: RunRequest, folder: Path) -> RunResult:
    """Store the result and the files of a run in its folder on this machine."""
    clear_run(folder)
    try:
        fields, packed = future.result()
    except Exception as error:  # noqa: BLE001 - any error of Dask or of the worker
        words = f"{type(error).__name__}: {error}"
        result = failed_result(request, folder, f"the cluster failed: {words}")
    else:
        if packed:
            unpack(packed, folder)
        result = replace(RunResult(**fields), folder=str(folder))
    request.save(folder)
    with contextlib.suppress(OSError):
        result.save()
    return result

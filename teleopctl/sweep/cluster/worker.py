"""Functions that the workers of a Dask cluster execute for a sweep."""

from __future__ import annotations

import shutil
import tempfile
import threading
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from teleopctl.base import __version__
from teleopctl.errors import RefusedError
from teleopctl.sweep.cluster.file_transfer import SentFolder, pack, unpack
from teleopctl.sweep.one_run import RunRequest
from teleopctl.sweep.process import RunProcesses, free_ports

_lock = threading.Lock()
# Keys: sweep IDs. A Dask worker process serves several sweeps.
_sweeps: dict[str, RunProcesses] = {}


def versions() -> dict[str, str]:
    """Return the versions of teleopctl and mujoco on this machine, by name; they must agree."""
    from importlib.metadata import version

    return {"teleopctl": __version__, "mujoco": version("mujoco")}


# Any: JSON values.
def run_on_worker(
    request_fields: dict[str, Any], sent_folder: SentFolder, archive: bytes, sweep_id: str
) -> tuple[dict[str, Any], bytes]:
    """Execute a run on this Dask worker; return its result as a dict, and its folder as an archive.

    Args:
        request_fields: Fields of a `RunRequest`, with paths of the requesting machine.
        sent_folder: Folder that was sent with the request.
        archive: Content of the folder, as the bytes of a tar archive.
        sweep_id: Identifier of the sweep.

    Returns:
        The fields of the `RunResult`, and the run's folder as the bytes of a tar archive.
    """
    from distributed import get_worker

    worker = get_worker()
    worker.log_event(sweep_id, request_fields["number"])
    home = Path(worker.local_directory).absolute()
    root = _sent_folder(home, sweep_id, archive)
    with tempfile.TemporaryDirectory(
        prefix="run-", dir=home, ignore_cleanup_errors=True
    ) as folder_name:
        folder = Path(folder_name)
        request = sent_folder.for_worker(RunRequest(**request_fields), root)
        request.save(folder)
        (port,) = free_ports(1)
        result = _processes(sweep_id).run(request, folder, port, port, root / sent_folder.cwd)
        if result is None:
            raise RefusedError("The sweep was stopped")
        try:
            packed = pack(folder)
        except RefusedError as error:
            result, packed = replace(result, result="failed", error=error.message), b""
        # With the requested values, not with the paths of this worker.
        done = replace(result, machine=str(worker.name), parameters=request_fields["parameters"])
        return asdict(done), packed


def stop_runs(sweep_id: str) -> None:
    """Interrupt the runs of a sweep on this Dask worker, and reject its further runs."""
    _processes(sweep_id).stop()


# Any: a Dask worker, which Client.run passes as this argument.
def remove_sweep(sweep_id: str, dask_worker: Any = None) -> None:
    """Remove the unpacked files of a finished sweep from a Dask worker."""
    with _lock:
        _sweeps.pop(sweep_id, None)
        home = Path(dask_worker.local_directory).absolute()
        shutil.rmtree(home / f"sweep-{sweep_id}", ignore_errors=True)


def _processes(sweep: str) -> RunProcesses:
    with _lock:
        return _sweeps.setdefault(sweep, RunProcesses(guarded=True))


def _sent_folder(home: Path, sweep: str, data: bytes) -> Path:
    """Return the folder of the files that were sent, unpacked once for all runs."""
    root = home / f"sweep-{sweep}"
    with _lock:
        if not root.is_dir():
            # The lock of this process is enough: no two workers share a home folder.
            draft = Path(tempfile.mkdtemp(dir=home))
            if data:
                unpack(data, draft)
            draft.rename(root)
    return root

"""Temporary folders that are removed even if their process was killed.

A process removes its folder when it ends. A killed process cannot: so each process holds a lock on
its folder, which the system releases with the process. The next process that makes a folder in the
same place, or calls `remove_abandoned`, removes those whose lock is free. A lock, unlike a PID, has
the same meaning in all containers that share the place.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

_PREFIX = "teleopctl-"
# A younger folder may not be locked yet.
_MADE_WITHIN_S = 5.0


class TemporaryFolder:
    """Private temporary folder, made at construction and removed at the end of the ``with`` block.

    Args:
        parent: Folder in which the temporary folder is made; must exist.
        is_needed: As in `remove_abandoned`.

    Attributes:
        path: Path of the temporary folder.
    """

    def __init__(self, parent: Path, is_needed: Callable[[int], bool] = lambda _: False) -> None:
        remove_abandoned(parent, is_needed)
        self.path = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{os.getpid()}-", dir=parent))
        self._lock = _lock(self.path)

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, *_: object) -> None:
        self.remove()

    def remove(self) -> None:
        """Remove the temporary folder and its content. Idempotent."""
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def remove_abandoned(
    parent: Path, is_needed: Callable[[int], bool] = lambda _: False, *, ended: int = 0
) -> None:
    """Remove temporary folders that killed processes of this user left, unless still needed.

    Args:
        parent: Folder that contains the temporary folders; need not exist.
        is_needed: Called with the PID of the process that made a folder. Returns whether processes
            that this process started still need the folder.
        ended: PID of a process that has ended for certain, whose folders are removed however young
            they are.
    """
    for path in parent.glob(f"{_PREFIX}*-*"):
        number = path.name.removeprefix(_PREFIX).partition("-")[0]
        if not number.isdecimal() or is_needed(int(number)):
            continue
        with contextlib.suppress(OSError):  # of another user, or already removed
            if path.is_symlink() or (hasattr(os, "getuid") and path.stat().st_uid != os.getuid()):
                continue
            age_s = time.time() - path.stat().st_ctime
            if age_s < _MADE_WITHIN_S and int(number) != ended:
                continue
            lock = _lock(path)
            if lock is not None or (sys.platform == "win32" and not _runs(int(number))):
                shutil.rmtree(path, ignore_errors=True)
            if lock is not None:
                os.close(lock)


def _lock(folder: Path) -> int | None:
    """Lock a folder as long as this process runs; None if another process holds the lock."""
    if sys.platform == "win32":
        return None
    import fcntl

    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


def _runs(pid: int) -> bool:
    import psutil

    return psutil.pid_exists(pid)

"""Temporary folders that are removed even if their process was killed.

A process that ends removes its own. One that is killed cannot: so each holds a lock on its folder,
which the system lets go with the process, and whoever makes the next folder there, or asks for it,
removes those whose lock is free. A lock, unlike a process id, means the same in every container
that shares the place.
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
# A folder is made and then locked.
_MADE_WITHIN_S = 5.0


class TemporaryFolder:
    """Private temporary folder, removed at the end of the ``with`` block.

    Args:
        parent: What it is made in; has to exist.
        is_needed: As in `remove_abandoned`.

    Attributes:
        path: The folder.
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
    """Remove the temporary folders that killed processes left in a folder.

    Args:
        parent: What they are in; need not exist.
        is_needed: Whether a folder is still needed though the process that made it, which had this
            id, is gone: by what that has started.
        ended: Id of a process of which it is known that it has ended.
    """
    for path in parent.glob(f"{_PREFIX}*-*"):
        number = path.name.removeprefix(_PREFIX).partition("-")[0]
        if not number.isdecimal() or is_needed(int(number)):
            continue
        with contextlib.suppress(OSError):  # another user's, or gone meanwhile
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
    """Lock a folder as long as this process runs; None where another one has it locked."""
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

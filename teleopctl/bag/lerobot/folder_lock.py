"""Lock of a folder, which two programs must not change at the same time."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path

from teleopctl.errors import RefusedError

try:
    import fcntl
except ImportError:  # Windows has no locks of folders
    _HAS_LOCKS = False
else:
    _HAS_LOCKS = True

_PERIOD_S = 0.1


class FolderLock:
    """Lock of a folder until `release`, or the end of the process, however it ends.

    The folder itself is locked, so that there is no file that a killed program leaves. Where there
    are no such locks, as on Windows and on some network file systems, nothing is locked.

    Args:
        folder: The folder, which exists.
        busy: Error that is raised if another program still holds the lock.
        longest_s: Longest wait for the other program, in seconds.

    Raises:
        RefusedError: Another program still holds the lock.
    """

    def __init__(self, folder: Path, busy: RefusedError, longest_s: float = 0.0) -> None:
        self._descriptor: int | None = None
        if not _HAS_LOCKS:
            return
        with contextlib.suppress(OSError):
            self._descriptor = os.open(folder, os.O_RDONLY)
        end_s = time.monotonic() + longest_s
        while self._is_busy():
            if time.monotonic() >= end_s:
                self.release()
                raise busy
            time.sleep(_PERIOD_S)

    def _is_busy(self) -> bool:
        """Try to lock; return whether another program holds the lock."""
        if self._descriptor is not None:
            with contextlib.suppress(OSError):
                try:
                    fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    return True
        return False

    def release(self) -> None:
        """Release the lock; more than once is allowed."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            os.close(descriptor)


@contextlib.contextmanager
def locked(folder: Path, busy: RefusedError, longest_s: float) -> Iterator[None]:
    """Return a context manager that holds a `FolderLock`.

    Raises:
        RefusedError: Another program still holds the lock.
    """
    lock = FolderLock(folder, busy, longest_s)
    try:
        yield
    finally:
        lock.release()

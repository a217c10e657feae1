"""A file that is being written is held, so that nobody repairs it meanwhile."""

from __future__ import annotations

import contextlib
import io

try:
    import fcntl
except ImportError:  # Windows, which holds what is open for writing by itself
    _HAS_LOCKS = False
else:
    _HAS_LOCKS = True


def hold(stream: io.IOBase) -> bool:
    """Lock a file until it is closed; return False if another program has locked it.

    The operating system lets go of it when the program dies, however it does.
    """
    if not _HAS_LOCKS:
        return True
    # Some network file systems have no locks: then nothing is held.
    with contextlib.suppress(OSError):
        try:
            fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True

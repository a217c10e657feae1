"""Files that nobody but their user may read: logs, parameters, progress, tokens.

What a program logs or is started with is its user's affair: names of hosts, paths, keys that stand
in parameters. The mode is given when the file is made, so that there is no moment in which others
can open it; the umask of a process is left alone, since nodes make files of their own.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys

from teleopctl.base.typed import TYPE_CHECKING

# Takes as long to import as half a command of the command line.
if TYPE_CHECKING:
    from pathlib import Path


def open_private(path: str | Path, flags: int) -> int:
    """Open a file as `os.open` does, with mode 0600; also the ``opener`` of `open`.

    A file that is there already gets that mode where it is the user's own; a device or a pipe keeps
    its own.

    Raises:
        OSError: It cannot be opened.
    """
    descriptor = os.open(path, flags | getattr(os, "O_CLOEXEC", 0), 0o600)
    if sys.platform != "win32":
        found = os.fstat(descriptor)
        is_own = stat.S_ISREG(found.st_mode) and found.st_uid == os.geteuid()
        if is_own and stat.S_IMODE(found.st_mode) & 0o077:
            with contextlib.suppress(OSError):  # file systems without modes
                os.fchmod(descriptor, 0o600)
    return descriptor


def write_private(path: str | Path, text: str) -> None:
    """Write a text file with mode 0600, atomically.

    Raises:
        OSError: It cannot be written.
    """
    draft = f"{path}.{os.getpid()}.new"
    try:
        with open(draft, "w", encoding="utf-8", opener=open_private) as file:
            file.write(text)
        os.replace(draft, path)  # noqa: PTH105 -- Path is a dear import
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(draft)  # noqa: PTH108 -- likewise
        raise

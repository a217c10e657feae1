"""Files with access for their owner only, and text files named by the user.

Logs and command lines of a program are private to its user: they contain host names, paths, and
keys in parameters. Their files are created with mode 0600, so that others can never open them. The
umask of the process stays as it is, since nodes create files too.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import InvalidFileError

if TYPE_CHECKING:
    from pathlib import Path


def open_private(path: str | Path, flags: int) -> int:
    """Open a file with mode 0600, and return its descriptor; also the ``opener`` of `open`.

    An existing file of the user gets that mode; a device or a pipe keeps its mode.

    Raises:
        OSError: The file cannot be opened.
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
        OSError: The file cannot be written.
    """
    draft = f"{path}.{os.getpid()}.new"
    try:
        with open(draft, "w", encoding="utf-8", opener=open_private) as file:
            file.write(text)
        os.replace(draft, path)  # noqa: PTH105 -- pathlib is slow to import
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(draft)  # noqa: PTH108 -- likewise
        raise


_POINTER = b"version https://git-lfs.github.com/"


def missing_content(path: Path) -> str:
    """Return the reason why a file lacks its content (a Git LFS pointer); empty if it has it.

    In a clone without Git LFS, pointer files stand in for large files.

    Raises:
        OSError: The file cannot be read.
    """
    if not path.is_file():
        return ""  # opening a pipe blocks until another process opens it for writing
    with path.open("rb") as stream:
        is_pointer = stream.read(len(_POINTER)) == _POINTER
    return "is only a Git LFS pointer: `git lfs pull` downloads it" if is_pointer else ""


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file; raise an InvalidFileError with its path if that fails.

    Raises:
        InvalidFileError: The file cannot be read, or is not UTF-8 text.
    """
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InvalidFileError(f"Cannot read {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InvalidFileError(f"Cannot read {path}: it is not UTF-8 text") from error

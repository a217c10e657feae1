"""Output streams of child processes: pipes or pseudo-terminals, and the lines in them."""

from __future__ import annotations

import errno
import os
from contextlib import contextmanager

from teleopctl.base.typed import TYPE_CHECKING, Iterator

if TYPE_CHECKING:
    from typing import IO


# Bounds the memory for a process that writes no line ends, in bytes.
_LONGEST_LINE = 1 << 16


class OutputStream:
    """Pipe or pseudo-terminal for one output stream of a child process.

    Attributes:
        written: File descriptor of the end that the child process writes to.
    """

    def __init__(self, read: int, written: int) -> None:
        self.written = written
        self._read: int | None = read

    def read(self) -> IO[bytes]:
        """Return the reading end as a binary file, only once; the caller has to close the file."""
        assert self._read is not None
        read, self._read = self._read, None
        return os.fdopen(read, "rb")

    def close(self) -> None:
        """Close the child's end in this process, and the reading end unless `read` took it."""
        os.close(self.written)
        if self._read is not None:
            os.close(self._read)


@contextmanager
def stream(*, as_terminal: bool = False) -> Iterator[OutputStream]:
    """Yield a new pipe or pseudo-terminal for a child's output; close the child's end later."""
    opened = OutputStream(*_terminal()) if as_terminal else OutputStream(*os.pipe())
    try:
        yield opened
    finally:
        opened.close()


def _terminal() -> tuple[int, int]:
    import pty  # not on Windows
    import tty

    read, written = pty.openpty()
    tty.setraw(written)  # keeps line ends as they are written
    return read, written


def lines(pipe: IO[bytes]) -> Iterator[bytes]:
    """Yield the lines that a process writes to a pipe; lines beyond 64 KiB come in parts."""
    while True:
        try:
            line = pipe.readline(_LONGEST_LINE)
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            return  # a terminal without writers
        if not line:
            return
        yield line

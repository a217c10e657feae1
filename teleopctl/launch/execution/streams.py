"""The streams of a process: pipes, or terminals where it is to think that it writes to one."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO

# A process that writes no line ends must not fill the memory.
_LONGEST_LINE = 1 << 16


class OutputStream:
    """Pipe of one output stream of a process.

    Attributes:
        written: The file descriptor that the process gets.
    """

    def __init__(self, read: int, written: int) -> None:
        self.written = written
        self._read: int | None = read

    def read(self) -> IO[bytes]:
        """Return the read end of the pipe; the caller closes it."""
        assert self._read is not None
        read, self._read = self._read, None
        return os.fdopen(read, "rb")

    def close(self) -> None:
        """Close the write end of the pipe, and the read end unless it was taken."""
        os.close(self.written)
        if self._read is not None:
            os.close(self._read)


@contextmanager
def stream(*, as_terminal: bool = False) -> Iterator[OutputStream]:
    """Open a stream for the block in which the process is started."""
    opened = OutputStream(*_terminal()) if as_terminal else OutputStream(*os.pipe())
    try:
        yield opened
    finally:
        opened.close()


def _terminal() -> tuple[int, int]:
    import pty  # which Windows lacks
    import tty

    read, written = pty.openpty()
    tty.setraw(written)  # line ends come as they are written
    return read, written


def lines(pipe: IO[bytes]) -> Iterator[bytes]:
    """Yield the lines that a process writes; very long ones in parts."""
    while True:
        try:
            line = pipe.readline(_LONGEST_LINE)
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            return  # a terminal to which nobody writes any more
        if not line:
            return
        yield line

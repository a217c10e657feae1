"""Standard streams whose failure does not end the process, and log files of limited size.

A log that has grown to half of its size limit is renamed to ``FILE.1``, which replaces the previous
one, and an empty file is started. ``TELEOPCTL_LOG_BYTES`` sets the limit of each process's log,
both files together.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import sys
import threading
from pathlib import Path

from teleopctl.base.files import open_private
from teleopctl.base.typed import TYPE_CHECKING, Callable, Mapping
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from typing import BinaryIO

    from _typeshed import ReadableBuffer

LOG_FILE = "TELEOPCTL_LOG_FILE"
"""Environment variable with the log file of a background process or a process of a launch."""

_LOG_BYTES = "TELEOPCTL_LOG_BYTES"
_DEFAULT_LOG_BYTES = 20_000_000
# Room for a few lines.
_SMALLEST_LOG_BYTES = 4096

# Errors of a stream that will never be read again: a pipe without a reader, a closed terminal.
_NO_READER = {errno.EPIPE, errno.EIO, errno.ENXIO, errno.EBADF, errno.ECONNRESET}

_rotating = threading.Lock()


def log_bytes(env: Mapping[str, str] = os.environ) -> int:
    """Return the size limit of one process's log in bytes, both of its files together.

    Raises:
        UsageError: ``TELEOPCTL_LOG_BYTES`` is not a number, or too small for a log.
    """
    text = env.get(_LOG_BYTES)
    if not text:
        return _DEFAULT_LOG_BYTES
    if not text.isascii() or not text.isdigit() or int(text) < _SMALLEST_LOG_BYTES:
        raise UsageError(
            f"{_LOG_BYTES}='{text}' is not a valid log size",
            hint=f"Give it in bytes, {_SMALLEST_LOG_BYTES} or more.",
        )
    return int(text)


def older_part(log_file: Path) -> Path:
    """Return the path of the older part of a log, ``FILE.1``, which may not exist."""
    return log_file.with_name(f"{log_file.name}.1")


class LogFile:
    """Log file of limited size with older lines in ``FILE.1``; thread-safe, writes never raise.

    Args:
        path: Path of the log file, to which lines are appended.
        on_trouble: Called with a sentence at the first write that fails, and again only after a
            write has succeeded.
    """

    def __init__(self, path: Path, on_trouble: Callable[[str], object] = lambda _: None) -> None:
        self._path = path
        self._on_trouble = on_trouble
        self._largest = log_bytes() // 2
        self._lock = threading.Lock()
        self._file: BinaryIO | None = None
        self._is_torn = False
        self._in_trouble = False
        self._is_closed = False

    def write(self, line: bytes) -> None:
        """Append a line to the log file; lose it, and report once, if it cannot be written."""
        trouble = None
        with self._lock:
            if self._is_closed:
                return
            try:
                self._append(line)
                self._in_trouble = False
            except OSError as error:
                if not self._in_trouble:
                    trouble = f"Cannot write {self._path}: {error.strerror}; lines will be missing"
                self._in_trouble = True
        if trouble is not None:
            self._on_trouble(trouble)

    def close(self) -> None:
        """Close the log file; lines written later are lost. Idempotent."""
        with self._lock:
            self._is_closed = True
            if self._file is not None:
                self._file.close()

    def _append(self, line: bytes) -> None:
        if self._file is None:
            self._file = os.fdopen(
                open_private(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), "ab", 0
            )
        if self._file.tell() + len(line) > self._largest:
            _begin_anew(self._path, [self._file.fileno()])
        # Keep a line that was only partly written, on a full disk, apart from the next one.
        data = b"\n" + line if self._is_torn else line
        written = 0
        while written < len(data):
            self._is_torn = written > 0 or self._is_torn
            written += self._file.write(data[written:])
        self._is_torn = False


def _begin_anew(path: Path, descriptors: list[int]) -> None:
    """Rename a log to its older part, and redirect the descriptors of the log to a new file."""
    fresh = path.with_name(f"{path.name}.new")
    try:
        new = open_private(fresh, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND)
        path.replace(older_part(path))
        fresh.replace(path)
    except OSError:
        # Windows cannot rename an open file. The limit has priority over older lines.
        with contextlib.suppress(OSError):
            os.ftruncate(descriptors[0], 0)
        return
    for descriptor in descriptors:
        os.dup2(new, descriptor, inheritable=os.get_inheritable(descriptor))
    os.close(new)


class _Output(io.RawIOBase):
    """A standard stream whose ``write`` always succeeds.

    Args:
        descriptor: 1 or 2.
        log_file: Log file of this process. If the stream writes to this file, the file is kept
            within its size limit; otherwise the stream continues there once its reader has gone.
        buffered: Whether a `_Buffer` writes to this object, rather than the text stream itself.
        lossless: Whether errors of a full disk and of a closed pipe are raised: the output is not
            a log but a result, which must not be lost silently.
    """

    def __init__(
        self, descriptor: int, log_file: Path | None, *, buffered: bool, lossless: bool
    ) -> None:
        super().__init__()
        self._descriptor = descriptor
        self._log_file = log_file
        self._buffered = buffered
        self._lossless = lossless
        self._largest = log_bytes() // 2
        # Interrupt that arrived during a write; `_Buffer` raises it after the write.
        self.postponed: list[KeyboardInterrupt] = []

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._descriptor

    def isatty(self) -> bool:
        return os.isatty(self._descriptor)

    def write(self, data: ReadableBuffer, /) -> int:
        left = memoryview(data).cast("B")
        size = len(left)
        if self._log_file is not None:
            self._keep_bound(self._log_file, size)
        written: list[int] = []
        try:
            while left:
                try:
                    # One step: an interrupt between write and append would lose the count.
                    written.extend(map(os.write, (self._descriptor,), (left,)))
                    left = left[written[-1] :]
                except BlockingIOError:
                    break  # a stopped terminal, which another program has made non-blocking
                except OSError as error:
                    if self._lossless and error.errno != errno.EIO:
                        raise
                    if error.errno not in _NO_READER or not self._redirect():
                        break
        except KeyboardInterrupt as interrupt:
            if not written or not self._buffered:
                raise
            # Raised here, it would make the buffer write the same bytes again.
            self.postponed[:] = [interrupt]
            return sum(written)
        return size

    def _keep_bound(self, log_file: Path, size: int) -> None:
        if self._is_log(self._descriptor, log_file, size):
            with _rotating:
                ours = [fd for fd in (1, 2) if self._is_log(fd, log_file, size)]
                if ours:
                    _begin_anew(log_file, ours)

    def _is_log(self, descriptor: int, log_file: Path, size: int) -> bool:
        """Whether a descriptor writes to the log and the log is full."""
        try:
            here = os.fstat(descriptor)
            return here.st_size + size > self._largest and os.path.samestat(here, log_file.stat())
        except OSError:
            return False

    def _redirect(self) -> bool:
        """Redirect the stream to the log, or to the null device without one."""
        for path in (self._log_file, os.devnull):
            if path is None:
                continue
            with contextlib.suppress(OSError):
                new = open_private(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
                os.dup2(new, self._descriptor)
                os.close(new)
                return True
        return False


class _Buffer(io.BufferedWriter):
    """Buffer that raises an interrupt of a write after it has counted the written bytes."""

    def __init__(self, raw: _Output) -> None:
        super().__init__(raw)
        self._postponed = raw.postponed

    def write(self, data: ReadableBuffer, /) -> int:
        count = super().write(data)
        self._raise_postponed()
        return count

    def flush(self) -> None:
        super().flush()
        self._raise_postponed()

    def _raise_postponed(self) -> None:
        # Only the main thread raises interrupts; other threads write too.
        if self._postponed and threading.current_thread() is threading.main_thread():
            raise self._postponed.pop()


def outlive_output(*, log_file: Path | None = None, lossless_stdout: bool = False) -> None:
    """Replace stdout and stderr by streams whose write errors do not end this process.

    On a full disk, lines are lost. A pipe whose reader has ended, or a closed terminal, is replaced
    by the process's log, or by the null device without one.

    Args:
        log_file: Log file of this process.
        lossless_stdout: Whether a full disk and a closed pipe stay errors for standard output, as
            for a command whose output is a result.
    """
    for name, descriptor in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name)
        if not isinstance(stream, io.TextIOWrapper) or stream.fileno() != descriptor:
            continue  # closed from the start, or replaced by the program
        with contextlib.suppress(OSError):
            stream.flush()
        lossless = lossless_stdout and descriptor == 1
        # A stream that is unbuffered (python -u) stays unbuffered.
        buffered = not stream.write_through
        raw = _Output(descriptor, log_file, buffered=buffered, lossless=lossless)
        setattr(
            sys,
            name,
            io.TextIOWrapper(
                _Buffer(raw) if buffered else raw,
                encoding=stream.encoding,
                errors=stream.errors,
                line_buffering=stream.line_buffering,
                write_through=stream.write_through,
            ),
        )


def discard_output() -> None:
    """Redirect stdout to the null device, so that unwritten output causes no error at exit."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, sys.stdout.fileno())
    os.close(null)


def take_log_file() -> Path | None:
    """Return this process's log file from the environment or None, and remove the variable."""
    path = os.environ.pop(LOG_FILE, None)
    return Path(path) if path else None

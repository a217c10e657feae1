"""Handler for the log files of a launch."""

from __future__ import annotations

import logging
import os
from io import TextIOWrapper
from logging.handlers import WatchedFileHandler
from pathlib import Path

from teleopctl.base.files import open_private

from .handlers import PerLoggerFormatting


class LogFileHandler(PerLoggerFormatting, WatchedFileHandler):
    """Handler that appends to a log file that the launch writes too.

    Attributes:
        waits_for_folder: Whether lines are kept until the launch has made its folder, which one
            that is only printed never does.
    """

    def __init__(self, path: str, *, encoding: str) -> None:
        super().__init__(path, encoding=encoding, errors="replace", delay=True)
        self.waits_for_folder = False
        self._kept: list[logging.LogRecord] = []

    def _open(self) -> TextIOWrapper:
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        stream = os.fdopen(open_private(self.baseFilename, flags), "ab")
        return TextIOWrapper(stream, encoding=self.encoding, errors=self.errors)

    def move(self, folder: Path) -> None:
        """Write to the file of the same name in another folder from now on."""
        self.flush()
        if self.stream is not None:
            self.stream.close()
            self.stream = None  # as its own `close` does
        self.baseFilename = str(folder.absolute() / Path(self.baseFilename).name)
        self.waits_for_folder = True

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record, unless standard output is the same file."""
        folder = Path(self.baseFilename).parent
        if self.waits_for_folder and not folder.is_dir():
            self._kept.append(record)
            return
        folder.mkdir(parents=True, exist_ok=True)
        kept, self._kept = self._kept, []
        if not _is_screen(self.baseFilename):
            for each in (*kept, record):
                super().emit(each)

    def flush(self) -> None:
        """Write the buffered records, if the folder exists."""
        if self._kept and Path(self.baseFilename).parent.is_dir():
            *_, last = self._kept
            self._kept.pop()
            self.emit(last)
        super().flush()


def _is_screen(path: str) -> bool:
    """Return whether standard output is the file, as in a detached launch."""
    try:
        return os.path.samestat(os.fstat(1), Path(path).stat())
    except OSError:
        return False

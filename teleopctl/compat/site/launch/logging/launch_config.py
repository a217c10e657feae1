"""Configuration of a launch's logging: screen, log files and formats."""

from __future__ import annotations

import logging
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.launch import LOG_FORMAT, SCREEN_FORMAT, current_log_directory, new_log_directory

from .handlers import PerLoggerFormatting

if TYPE_CHECKING:
    from typing import Literal

    from ._log_file import LogFileHandler

    Style = Literal["%", "{", "$"]

known_loggers: set[logging.Logger] = set()
"""The loggers that write where the launch does."""


class LaunchConfig:
    """Configuration of a launch's logging: level, formats, screen and folder.

    Attributes:
        file_handlers: Handlers of the log files, by file name.
    """

    def __init__(self) -> None:
        self.file_handlers: dict[str, logging.Handler] = {}
        self._screen_handler = _ScreenHandler()
        self.reset()

    def reset(self) -> None:
        """Restore the defaults."""
        self._log_dir: Path | None = None
        self._is_taken_over = False
        # Any handler: the factory's caller has its type.
        self._factory: Callable[..., logging.Handler] | None = None
        for handler in self.file_handlers.values():
            handler.close()
        self.file_handlers = {}
        logging.root.setLevel(logging.INFO)
        SCREEN_FORMAT.reset()
        LOG_FORMAT.reset()
        self._screen_handler.setFormatter(SCREEN_FORMAT.formatter())

    @property
    def level(self) -> int:
        """Minimum severity."""
        return logging.root.getEffectiveLevel()

    @level.setter
    def level(self, new_level: int) -> None:
        logging.root.setLevel(new_level)

    @property
    def log_dir(self) -> str:
        """Folder of the launch's logs, created when the first process starts."""
        if self._log_dir is None:
            here = current_log_directory()
            self._log_dir, self._is_taken_over = here or new_log_directory(), here is not None
        return str(self._log_dir)

    @log_dir.setter
    def log_dir(self, new_log_dir: str | None) -> None:
        if new_log_dir is not None:
            if self.file_handlers:
                warnings.warn(
                    f"Loggers have been already configured to output to log files below "
                    f"{self._log_dir}. Proceed at your own risk.",
                    stacklevel=2,
                )
            if not Path(new_log_dir).is_dir():
                raise ValueError(f"{new_log_dir} is not a directory")
        self._log_dir = None if new_log_dir is None else Path(new_log_dir)
        self._is_taken_over = False

    def take_over(self, folder: Path) -> None:
        """Take over the log folder of a launch that begins."""
        if folder != Path() and folder != self._log_dir:
            self._log_dir, self._is_taken_over = folder, True
            for handler in self.file_handlers.values():
                if isinstance(handler, _log_file_handler()):
                    handler.move(folder)

    @property
    def log_handler_factory(self) -> Callable[..., logging.Handler]:
        """Function that creates the handler of a log file from its path and ``encoding``."""
        return self._factory or _log_file_handler()

    @log_handler_factory.setter
    def log_handler_factory(self, new_log_handler_factory: Callable[..., logging.Handler]) -> None:
        self._factory = new_log_handler_factory

    def set_screen_format(self, screen_format: str, *, screen_style: Style | None = None) -> None:
        """Set the format of records on the screen.

        Args:
            screen_format: ``default``, ``default_with_timestamp``, or one of Python's formats.
            screen_style: Style of the format's fields, as of `logging.Formatter`.

        Raises:
            ValueError: There is a style for a format that has its own.
        """
        SCREEN_FORMAT.choose(screen_format, screen_style)
        self._screen_handler.setFormatter(SCREEN_FORMAT.formatter())

    def get_screen_handler(self) -> logging.Handler:
        """Return the handler of the screen."""
        return self._screen_handler

    def set_log_format(self, log_format: str, *, log_style: Style | None = None) -> None:
        """Set the format of records in the launch's log.

        Args:
            log_format: ``default``, or one of Python's formats.
            log_style: Style of the format's fields, as of `logging.Formatter`.

        Raises:
            ValueError: There is a style for a format that has its own.
        """
        LOG_FORMAT.choose(log_format, log_style)
        for handler in self.file_handlers.values():
            handler.setFormatter(LOG_FORMAT.formatter())

    def get_log_file_path(self, file_name: str = "launch.log") -> str:
        """Return the path of a log file."""
        return str(Path(self.log_dir) / file_name)

    def get_log_file_handler(self, file_name: str = "launch.log") -> logging.Handler:
        """Return the handler of a log file; the same object for the same file."""
        if file_name not in self.file_handlers:
            path = self.get_log_file_path(file_name)
            made = self.log_handler_factory(path, encoding="utf-8")
            made.setFormatter(LOG_FORMAT.formatter())
            if isinstance(made, _log_file_handler()):
                made.waits_for_folder = self._is_taken_over
            self.file_handlers[file_name] = made
        return self.file_handlers[file_name]


class _ScreenHandler(PerLoggerFormatting):
    """Handler that writes to the current `sys.stdout`."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record."""
        sys.stdout.write(self.format(record) + "\n")
        sys.stdout.flush()


def _log_file_handler() -> type[LogFileHandler]:
    from ._log_file import LogFileHandler  # logging.handlers takes 6 ms to import

    return LogFileHandler

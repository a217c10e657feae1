"""``launch.logging``: loggers that write as the launch's own lines do.

What processes write is relayed by the launch itself and passes through no logger.
"""

from __future__ import annotations

import logging
import sys
from pathlib import Path

from teleopctl.launch import new_log_directory

_FORMATS = {
    "default": "[{levelname}] [{name}]: {message}",
    "default_with_timestamp": "{created:.7f} [{levelname}] [{name}]: {message}",
}


class _ScreenHandler(logging.Handler):
    """Writes to what is standard output at that time."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line."""
        sys.stdout.write(self.format(record) + "\n")
        sys.stdout.flush()


class LaunchConfig:
    """What lines look like, and where logs are."""

    def __init__(self) -> None:
        self._handler = _ScreenHandler()
        self.reset()

    def reset(self) -> None:
        """Forget what was set."""
        self._log_dir: Path | None = None
        logging.root.setLevel(logging.INFO)
        self.set_screen_format("default")

    @property
    def level(self) -> int:
        """The least level that is shown."""
        return logging.root.getEffectiveLevel()

    @level.setter
    def level(self, new_level: int) -> None:
        logging.root.setLevel(new_level)

    @property
    def log_dir(self) -> str:
        """The folder of the launch's logs."""
        if self._log_dir is None:
            self._log_dir = new_log_directory()
        return str(self._log_dir)

    @log_dir.setter
    def log_dir(self, new_log_dir: str | None) -> None:
        if new_log_dir is not None and not Path(new_log_dir).is_dir():
            raise ValueError(f"{new_log_dir} is not a directory")
        self._log_dir = None if new_log_dir is None else Path(new_log_dir)

    def take_over(self, folder: Path) -> None:
        """Take the folder of a launch that begins, which need not exist yet."""
        if folder != Path():
            self._log_dir = folder

    def get_log_file_path(self, file_name: str = "launch.log") -> str:
        """Return the path of a log."""
        return str(Path(self.log_dir) / file_name)

    def set_screen_format(self, screen_format: str, *, screen_style: str | None = None) -> None:
        """Set what lines look like.

        Args:
            screen_format: ``default``, ``default_with_timestamp``, or one of Python's formats.
            screen_style: How its fields are marked, for one of Python's formats.

        Raises:
            ValueError: There is a style for a format that has its own.
        """
        if screen_format in _FORMATS and screen_style is not None:
            raise ValueError(
                f'Cannot set a custom format style for the "{screen_format}" screen format.'
            )
        text = _FORMATS.get(screen_format, screen_format).replace("{msg}", "{message}")
        if screen_style == "%":
            self._handler.setFormatter(logging.Formatter(text, style="%"))
        elif screen_style == "$":
            self._handler.setFormatter(logging.Formatter(text, style="$"))
        else:
            self._handler.setFormatter(logging.Formatter(text, style="{"))

    def get_screen_handler(self) -> logging.Handler:
        """Return what writes to the screen."""
        return self._handler


launch_config = LaunchConfig()


def reset() -> None:
    """Forget what was set."""
    launch_config.reset()


def get_logger(name: str | None = None) -> logging.Logger:
    """Return a logger that writes to the screen."""
    logger = logging.getLogger(name)
    handler = launch_config.get_screen_handler()
    if handler not in logger.handlers:
        logger.addHandler(handler)
    return logger

"""How the lines of a launch look on the screen and in its log, in the words of ROS 2's launch.

Whoever runs a launch chooses by ``OVERRIDE_LAUNCH_SCREEN_FORMAT`` and
``OVERRIDE_LAUNCH_LOG_FORMAT``, a Python launch file by ``launch.logging.launch_config``.
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from logging import Formatter

    Style = Literal["%", "{", "$"]

_PLAIN = "[{levelname}] [{name}]: {message}"
_WITH_TIME = "{created:.7f} [{levelname}] [{name}]: {message}"
_LEVELS = {"DEBUG": 10, "INFO": 20, "WARNING": 30, "ERROR": 40, "CRITICAL": 50}


class LineFormat:
    """Format of log lines: ROS 2's, unless an environment variable sets another.

    Args:
        names: Formats that have a name; the first is ``default``.
        variable: The environment variable that decides for everybody.
    """

    def __init__(self, names: Mapping[str, str], variable: str) -> None:
        self._names = names
        self._variable = variable
        self.reset()

    def reset(self) -> None:
        """Restore the default format."""
        self._text = self._names["default"]
        self._formatter: Formatter | None = None
        if os.environ.get(self._variable):
            self.choose("default")

    @property
    def is_default(self) -> bool:
        """Whether the format is the default."""
        return self._text == self._names["default"]

    def choose(self, text: str, style: Style | None = None) -> None:
        """Set the format.

        Args:
            text: One that has a name, or one of Python's ``logging``.
            style: How fields are marked in one of Python's; by default by braces.

        Raises:
            ValueError: There is a style for a format that has a name, or the format is none.
        """
        chosen = os.environ.get(self._variable)
        if chosen:
            # As in ROS 2: escapes stand for the characters that they name.
            text, style = chosen.encode("latin1", "backslashreplace").decode("unicode_escape"), "{"
        elif text in self._names and style is not None:
            raise ValueError(f'Cannot set a custom format style for the "{text}" format.')
        self._text = self._names.get(text, text)
        self._formatter = None if self.is_default else _formatter(self._text, style or "{")

    def formatter(self) -> Formatter:
        """Return the format as a formatter of Python's logging."""
        return self._formatter or _formatter(self._text, "{")

    def line(self, level: str, name: str, message: str) -> str:
        """Return a formatted line, without line break."""
        if self._formatter is None:
            return self._text.format(
                levelname=level, name=name, message=message, created=time.time()
            )
        from logging import LogRecord

        number = _LEVELS.get(level, _LEVELS["INFO"])
        record = LogRecord(name, number, "launch", 0, message, None, None)
        record.levelname = level
        return self._formatter.format(record)


def _formatter(text: str, style: Style) -> Formatter:
    from logging import Formatter

    # ROS 2's own formats say ``msg``, which lacks what a logger is to put into the text.
    return Formatter(text.replace("{msg}", "{message}") if style == "{" else text, style=style)


SCREEN_FORMAT = LineFormat(
    {"default": _PLAIN, "default_with_timestamp": _WITH_TIME}, "OVERRIDE_LAUNCH_SCREEN_FORMAT"
)
LOG_FORMAT = LineFormat({"default": _WITH_TIME}, "OVERRIDE_LAUNCH_LOG_FORMAT")

"""``launch.logging.handlers``: handlers with a formatter for each logger."""

from __future__ import annotations

import importlib
import logging
from typing import Any


class PerLoggerFormatting(logging.Handler):
    """Mix-in of handlers that adds formatters for single loggers."""

    # Any: what the handler takes.
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._formatters: dict[str, logging.Formatter] = {}

    def setFormatterFor(self, logger: logging.Logger, formatter: logging.Formatter) -> None:  # noqa: N802 -- the original's name
        """Set the formatter of a logger."""
        self._formatters[logger.name] = formatter

    def unsetFormatterFor(self, logger: logging.Logger) -> None:  # noqa: N802 -- the original's name
        """Unset the formatter of a logger."""
        self._formatters.pop(logger.name, None)

    def format(self, record: logging.LogRecord) -> str:
        """Return the formatted record."""
        own = self._formatters.get(record.name)
        return super().format(record) if own is None else own.format(record)


def with_per_logger_formatting(cls: type[logging.Handler]) -> type[logging.Handler]:
    """Return a handler class with formatters for single loggers."""
    return type(cls.__name__, (PerLoggerFormatting, cls), {"__doc__": cls.__doc__})


# Any: one of Python's handlers, imported on first use.
def __getattr__(name: str) -> Any:
    # Python asks modules for names such as __path__; logging.handlers takes 4 ms to import.
    for module in () if name.startswith("_") else ("logging", "logging.handlers"):
        found = getattr(importlib.import_module(module), name, None)
        if isinstance(found, type) and issubclass(found, logging.Handler):
            made = globals()[name] = with_per_logger_formatting(found)
            return made
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

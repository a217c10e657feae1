"""``launch.logging``: loggers that write to the screen and the log of the launch.

What processes write is relayed by the launch itself and passes through no logger.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from typing import Any

from teleopctl.errors import TeleopctlError
from teleopctl.launch import output_alias, output_table

from . import handlers
from .launch_config import LaunchConfig, known_loggers as _known_loggers

launch_config = LaunchConfig()


def reset() -> None:
    """Reset the configuration, and remove the handlers of the loggers."""
    for logger in _known_loggers:
        logger.setLevel(logging.NOTSET)
        logger.handlers.clear()
    _known_loggers.clear()
    launch_config.reset()


def log_launch_config(*, logger: logging.Logger = logging.root) -> None:
    """Log the folder of the logs and the level."""
    if launch_config.file_handlers:
        logger.info("All log files can be found below %s", launch_config.log_dir)
    logger.info("Default logging verbosity is set to %s", logging.getLevelName(launch_config.level))


def get_logger(name: str | None = None) -> logging.Logger:
    """Return a logger that writes to the screen and to the log of the launch."""
    logger = logging.getLogger(name)
    _write_to(logger, launch_config.get_screen_handler())
    _write_to(logger, launch_config.get_log_file_handler())
    return logger


# Any: words, or a mapping from streams to a word or several.
def get_output_loggers(process_name: str, output_config: Any) -> tuple[logging.Logger, ...]:
    """Return the loggers for a process's stdout and stderr.

    Args:
        process_name: The process.
        output_config: ``screen``, ``log``, ``both``, ``own_log`` or ``full``, or for each of
            ``stdout``, ``stderr`` and ``both`` the words ``screen``, ``log`` and ``own_log``.

    Raises:
        ValueError: The value is none of these.
    """
    outputs = _outputs(output_config)
    combined = "own_log" in _destinations(output_config, "both")
    loggers = []
    for source, output in zip(("stdout", "stderr"), outputs, strict=True):
        logger = logging.getLogger(f"{process_name}-{source}")
        loggers.append(logger)
        _known_loggers.add(logger)
        logger.propagate = False
        if output.screen:
            _write_to(logger, launch_config.get_screen_handler(), "{message}")
        if output.log:
            _write_to(logger, launch_config.get_log_file_handler(), "{created:.7f} {message}")
        if output.own_log:
            _write_to_own(logger, f"{process_name}-{source}.log")
        if combined:
            _write_to_own(logger, f"{process_name}.log")
    return tuple(loggers)


# Any, twice: see `get_output_loggers`.
def _outputs(config: Any) -> tuple[Any, Any]:
    try:
        if isinstance(config, str):
            return output_alias(config)
        if isinstance(config, Mapping):
            return output_table({source: _words(words) for source, words in config.items()})
    except TeleopctlError as error:
        raise ValueError(error.message) from error
    raise ValueError(f"{config} is not a valid output configuration")


def _destinations(config: Any, source: str) -> frozenset[str]:
    if isinstance(config, str):
        return frozenset({"own_log"} if config in ("own_log", "full") else ())
    return _words(config.get(source, ()))


def _words(words: str | Iterable[str]) -> frozenset[str]:
    return frozenset({words} if isinstance(words, str) else words)


def _write_to(logger: logging.Logger, handler: logging.Handler, text: str | None = None) -> None:
    _known_loggers.add(logger)
    # Each logger has its own handlers, so records must not propagate to its parents.
    logger.propagate = False
    if handler not in logger.handlers:
        if text is not None and isinstance(handler, handlers.PerLoggerFormatting):
            handler.setFormatterFor(logger, logging.Formatter(text, style="{"))
        logger.addHandler(handler)


def _write_to_own(logger: logging.Logger, file_name: str) -> None:
    handler = launch_config.get_log_file_handler(file_name)
    handler.setFormatter(logging.Formatter("{message}", style="{"))
    _write_to(logger, handler)


__all__ = ["get_logger", "get_output_loggers", "handlers", "launch_config", "reset"]

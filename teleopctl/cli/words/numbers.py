"""Numbers that an option may not have."""

from __future__ import annotations

from teleopctl.errors import UsageError


def check_not_negative(**options: float | None) -> None:
    """Raise for negative values of options, which are named as on the command line.

    Raises:
        UsageError: One is negative.
    """
    for name, value in options.items():
        if value is not None and value < 0:
            raise UsageError(f"{_flag(name)} must not be negative, got {value:g}")


def check_positive(**options: float | None) -> None:
    """Raise for option values that are not greater than zero.

    Raises:
        UsageError: One is not.
    """
    for name, value in options.items():
        if value is not None and value <= 0:
            raise UsageError(f"{_flag(name)} must be greater than zero, got {value:g}")


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"

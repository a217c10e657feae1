"""What a check has to say."""

from __future__ import annotations

from teleopctl.base.typed import NamedTuple


class Finding(NamedTuple):
    """A fault or a possible fault, with a hint.

    Attributes:
        text: What, and where.
        hint: What to do about it.
        is_error: Whether it fails the check by itself; else it is a warning.
    """

    text: str
    hint: str = ""
    is_error: bool = True


def warning(text: str, hint: str = "") -> Finding:
    """Return a finding that is no certain fault."""
    return Finding(text, hint, is_error=False)

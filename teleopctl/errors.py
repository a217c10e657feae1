"""The error that every floor raises when a person has to do something about it."""

from __future__ import annotations

from collections.abc import Iterable

EXIT_INTERRUPTED = 130
"""The exit status after Ctrl-C, as shells have it."""


class TeleopctlError(Exception):
    """A failure with a message for a person and, where there is one, the next thing to do.

    The command line prints ``message`` and ``hint`` to stderr and ends with ``exit_status``;
    a traceback appears only with ``--debug``.

    Args:
        message: What is wrong and where, in one sentence.
        hint: What to do about it, or None.
        exit_status: 1 when the operation failed, 2 when it was asked for wrongly.
    """

    def __init__(self, message: str, *, hint: str | None = None, exit_status: int = 1) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        self.exit_status = exit_status


def did_you_mean(name: str, known: Iterable[str]) -> str | None:
    """A hint that names what is spelt alike, or None when nothing is."""
    from difflib import get_close_matches

    matches = get_close_matches(name, list(known), n=3)
    return f"Did you mean {' or '.join(matches)}?" if matches else None

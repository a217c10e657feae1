"""Line of a user's launch file that created an entity or raised an error."""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path

from teleopctl.base.extras import missing_module_hint
from teleopctl.errors import LaunchError, NotFoundError, TeleopctlError
from teleopctl.launch import Place

_OURS = str(Path(__file__).resolve().parents[3])
_LIBRARY = str(Path(os.__file__).parent)


def _is_a_users(file: str) -> bool:
    return not file.startswith((_OURS, _LIBRARY, "<"))


def here() -> Place:
    """Return the innermost line of a user's file on the call stack."""
    frame = sys._getframe(1)  # noqa: SLF001 -- inspect.stack reads every file on the way
    while frame.f_back is not None and not _is_a_users(frame.f_code.co_filename):
        frame = frame.f_back
    return Place(Path(frame.f_code.co_filename), frame.f_lineno)


def blamed(error: Exception, doing: str) -> TeleopctlError:
    """Return an error that names the innermost line of a user's file that led to an exception.

    Args:
        error: What was raised.
        doing: Description of the operation, for exceptions without a text.
    """
    if isinstance(error, RuntimeError) and isinstance(error.__cause__, TeleopctlError):
        error = error.__cause__.with_traceback(error.__traceback__)
    if isinstance(error, TeleopctlError) and error.place is not None:
        return error
    lines = [
        f"{entry.filename}:{entry.lineno}"
        for entry in traceback.extract_tb(error.__traceback__)
        if _is_a_users(entry.filename)
    ]
    if isinstance(error, TeleopctlError):
        return error.at(lines[-1]) if lines else error
    text = str(error) or doing
    if not isinstance(error, RuntimeError):
        text = f"{type(error).__name__}: {text}"
    # --skip-missing may ignore it, such as a package that ament_index_python does not find.
    kind = NotFoundError if isinstance(error.__cause__, NotFoundError) else LaunchError
    told = kind(text, hint=missing_module_hint(error))
    return told.at(lines[-1]) if lines else told

"""The line of a user's code that an exception comes from.

A plug-in is called by teleopctl, and in turn calls teleopctl, Python's library and other packages.
The line to look at is the innermost one of the plug-in's own code.
"""

from __future__ import annotations

import os

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

_OURS = os.path.dirname(os.path.dirname(os.path.abspath(__file__))) + os.sep  # noqa: PTH100, PTH120 -- paths of frames are texts
_LIBRARY = os.path.dirname(os.path.abspath(os.__file__)) + os.sep  # noqa: PTH100, PTH120
_INSTALLED = f"{os.sep}site-packages{os.sep}", f"{os.sep}dist-packages{os.sep}"


def is_user_code(file: str) -> bool:
    """Return whether a source file is the user's: not teleopctl's, Python's or a package's."""
    return bool(file) and not (
        file.startswith((_OURS, _LIBRARY, "<")) or any(part in file for part in _INSTALLED)
    )


def origin_of(error: BaseException) -> str | None:
    """Return the user's (else a package's) line that raised an exception as ``file:line``, or None.

    For a syntax error that is the place of the error. Otherwise it is the innermost line of user
    code or, if all code is installed, of the package that teleopctl called. None without such a
    line.
    """
    if isinstance(error, SyntaxError) and error.filename and os.path.isfile(error.filename):  # noqa: PTH113
        return f"{error.filename}:{error.lineno}"
    lines = list(_lines(error))
    own = [line for line in lines if is_user_code(line[0].f_code.co_filename)]
    if not own:
        installed = [line for line in lines if _is_installed(line[0].f_code.co_filename)]
        own = [line for line in installed if _package(line[0]) == _package(installed[0][0])]
    return f"{own[-1][0].f_code.co_filename}:{own[-1][1]}" if own else None


def with_origin(error: BaseException) -> str:
    """Return an exception as text: ``Class: message (file:line)``, without the place if unknown."""
    # str() of a SyntaxError ends with file name and line, without the folder.
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    words = f"{type(error).__name__}: {text}" if text else type(error).__name__
    place = origin_of(error)
    return f"{words} ({place})" if place else words


def _lines(error: BaseException) -> Iterator[tuple[FrameType, int]]:
    """Frames and line numbers of an exception's traceback, the outermost first."""
    trace = error.__traceback__
    while trace is not None:
        yield trace.tb_frame, trace.tb_lineno
        trace = trace.tb_next


def _is_installed(file: str) -> bool:
    return not file.startswith(_OURS) and any(part in file for part in _INSTALLED)


def _package(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__", "")).partition(".")[0]

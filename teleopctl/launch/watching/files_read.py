"""Which files this process reads, by whatever code: a launch file's own, xacro's, a library's."""

from __future__ import annotations

import importlib.util
import os
import sys
import sysconfig
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

# Packages are found by these; they are read by the hundred, and no process is made from them.
_OF_PACKAGES = frozenset(
    {"package.xml", "setup.py", "setup.cfg", "pyproject.toml", "CMakeLists.txt", "pyvenv.cfg"}
)
_WRITES = os.O_WRONLY | os.O_RDWR

_note: Callable[[str, bool], object] | None = None
_thread = 0
_is_installed = False


@contextmanager
def files_read() -> Iterator[set[Path]]:
    """Collect the user's files that this thread reads in the block.

    What the block itself writes does not count, since it would be written again with each reading.
    """
    global _note, _thread
    found: set[Path] = set()
    read: set[str] = set()
    written: set[str] = set()
    _install()
    _note, _thread = (
        lambda path, writes: (written if writes else read).add(path),
        (threading.get_ident()),
    )
    try:
        yield found
    finally:
        _note = None
        paths = {Path(_source(path)).absolute() for path in read - written}
        found.update(path for path in paths if is_of_user(path) and path.is_file())


def is_of_user(path: Path) -> bool:
    """Return whether a file is the user's: not Python's, a library's or teleopctl's."""
    return path.name not in _OF_PACKAGES and not any(map(path.is_relative_to, _others()))


@cache
def _others() -> tuple[Path, ...]:
    installed = sysconfig.get_paths()
    folders = [installed[key] for key in ("stdlib", "platstdlib", "purelib", "platlib")]
    own = Path(__file__).parents[2]
    return (*map(Path, dict.fromkeys(folders)), own, Path("/proc"), Path("/sys"), Path("/dev"))


def _source(path: str) -> str:
    """The source of a module of which the compiled form was read."""
    if path.endswith(".pyc"):
        try:
            return importlib.util.source_from_cache(path)
        except ValueError:
            return path
    return path


def _install() -> None:
    # A hook stays until the end of the process; only a launch that watches has one.
    global _is_installed
    if not _is_installed:
        _is_installed = True
        sys.addaudithook(_on_event)


# Any: the arguments of an event are what its place in Python says.
def _on_event(event: str, arguments: tuple[Any, ...]) -> None:
    if event != "open" or _note is None or _thread != threading.get_ident():
        return
    path, _, flags = arguments
    if isinstance(path, bytes):
        path = os.fsdecode(path)
    if isinstance(path, str):
        _note(path, bool(flags & _WRITES))

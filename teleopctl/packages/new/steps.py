"""What is done to make a package, in order."""

from __future__ import annotations

import os
from typing import NamedTuple


class Note(NamedTuple):
    """A line to print."""

    text: str


class Folder(NamedTuple):
    """A folder to create."""

    path: str


class File(NamedTuple):
    """A file to write.

    Attributes:
        path: Its path.
        text: What it holds.
        is_told: Whether its path is told.
    """

    path: str
    text: str
    is_told: bool = True


Step = Note | Folder | File


def joined(*parts: str) -> str:
    """Join the parts of a path, keeping a leading ``./``."""
    return os.path.join(*parts)  # noqa: PTH118 -- a Path would drop the ./

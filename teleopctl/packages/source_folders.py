"""Search for folders of source packages by their ``package.xml``."""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

# Thirty public ROS repositories in one folder have 350 packages in 1,000 searched folders, which
# takes 27 ms with a warm file system cache.
_MAX_FOLDERS = 2000
_IGNORED = frozenset({"AMENT_IGNORE", "CATKIN_IGNORE", "COLCON_IGNORE", "pyvenv.cfg"})
"""Names of files that exclude their folder from the search."""
_SKIPPED_FOLDERS = frozenset(
    {"__pycache__", "build", "dist", "install", "log", "node_modules", "site-packages", "venv"}
)
# Compiled at the first package: most commands find none.
_COMMENT = r"(?s)<!--.*?-->"
_NAME = r"<name>\s*([A-Za-z0-9_\-]+)\s*</name>"


def package_name(manifest: Path) -> str | None:
    """Return the name in a ``package.xml``; None if the file cannot be read or has no name."""
    text = text_of(manifest)
    match = None if text is None else re.search(_NAME, re.sub(_COMMENT, "", text))
    return match.group(1) if match else None


def enclosing_package(folder: Path) -> Path | None:
    """Return the folder with ``package.xml`` that is, or contains, a folder; or None."""
    return next((f for f in (folder, *folder.parents) if (f / "package.xml").is_file()), None)


def workspace_of(folder: Path) -> Path | None:
    """Return a package's nearest parent folder that is named ``src`` or has ``.git``; or None.

    Args:
        folder: Folder of the package.
    """
    return next((f for f in folder.parents if f.name == "src" or (f / ".git").exists()), None)


def find_package_folders(
    root: Path, on_cut: Callable[[int], object] = lambda _: None
) -> Iterator[tuple[str | None, Path]]:
    """Yield name (or None) and folder of the source packages below a folder, nearest first.

    The name is None if `package_name` returns None.

    The search is breadth first and limited to a number of folders, so that a command in a home
    folder stays fast. Hidden folders, virtual environments, colcon's outputs and folders marked
    ``COLCON_IGNORE``, ``AMENT_IGNORE`` or ``CATKIN_IGNORE`` are skipped, and so are packages
    installed below a prefix, and folders inside a package. Links to folders are followed, as colcon
    does; each folder is visited once.

    Args:
        root: Folder to search.
        on_cut: Called with the limit on folders when the limit ends the search.
    """
    pending = deque([(str(root), os.path.realpath(root))])
    met = {pending[0][1]}
    seen = 0
    while pending and seen < _MAX_FOLDERS:
        folder, real = pending.popleft()
        seen += 1
        try:
            with os.scandir(folder) as found:
                entries = sorted(found, key=lambda entry: entry.name)
        except OSError:
            continue
        names = {entry.name for entry in entries}
        if not names.isdisjoint(_IGNORED) or ("ament_index" in names and folder.endswith("share")):
            continue
        if "package.xml" in names:
            yield package_name(Path(folder, "package.xml")), Path(folder)
            continue
        for entry in entries:
            if entry.name[0] == "." or entry.name in _SKIPPED_FOLDERS or not _is_folder(entry):
                continue
            inside = os.path.realpath(entry.path) if entry.is_symlink() else f"{real}/{entry.name}"
            if inside not in met:
                met.add(inside)
                pending.append((entry.path, inside))
    if pending:
        on_cut(_MAX_FOLDERS)


def _is_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:  # a link into a folder without permission
        return False


def text_of(file: Path) -> str | None:
    """Return the text of a UTF-8 file, faulty bytes replaced; None if it cannot be read."""
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None

"""Which files a ``CMakeLists.txt`` installs, read without running CMake.

ROS 2's packages of descriptions and launch files install whole folders,
``install(DIRECTORY description/urdf bringup/launch DESTINATION share/${PROJECT_NAME})``. Such calls
are read, with the project's name and what ``set`` gave a name; what names other variables is left
out. Patterns that exclude files are not followed: a file too many does no harm.
"""

from __future__ import annotations

import os
import posixpath
import re
from pathlib import Path
from typing import Final

_COMMENT: Final = re.compile(r"#[^\n]*")
_CALL: Final = re.compile(r"\b(project|set|install)\s*\(([^()]*)\)", re.IGNORECASE)
_WORD: Final = re.compile(r'"([^"]*)"|(\S+)')
_VARIABLE: Final = re.compile(r"\$\{(\w+)\}")
_SOURCE_FOLDERS: Final = ("CMAKE_CURRENT_SOURCE_DIR", "CMAKE_SOURCE_DIR", "PROJECT_SOURCE_DIR")
_MOST_FILES: Final = 10_000  # a description with 2,000 meshes is a large one

# What follows the sources in a call.
_OPTIONS: Final = re.compile(
    "COMPONENT|CONFIGURATIONS|DESTINATION|(DIRECTORY_|FILE_)?PERMISSIONS|EXCLUDE_FROM_ALL"
    "|FILES_MATCHING|MESSAGE_NEVER|OPTIONAL|PATTERN|REGEX|RENAME|TYPE|USE_SOURCE_PERMISSIONS"
)


def installed_files(text: str, folder: Path) -> list[tuple[str, list[str]]]:
    """What is installed where, in the form of ``setup.py``'s ``data_files``.

    Args:
        text: The script.
        folder: Where it lies.

    Returns:
        Pairs of a folder, such as ``share/arm/launch``, and files, relative to the script's folder.
    """
    values = dict.fromkeys(_SOURCE_FOLDERS, ".") | {"CMAKE_INSTALL_DATADIR": "share"}
    entries: list[tuple[str, list[str]]] = []
    for call in _CALL.finditer(_COMMENT.sub("", text)):
        words = [_filled_in(quoted or bare, values) for quoted, bare in _WORD.findall(call[2])]
        match call[1].lower(), words:
            case "project", [str(name), *_]:
                values["PROJECT_NAME"] = values["CMAKE_PROJECT_NAME"] = name
            case "set", [str(name), str(value)]:
                values[name] = value
            case "install", [("DIRECTORY" | "FILES" | "PROGRAMS") as kind, *rest]:
                entries += _entries(kind, rest, folder)
    return entries


def _filled_in(word: str, values: dict[str, str]) -> str | None:
    """A word with the values of its variables, or None where one is not known."""
    if any(name not in values for name in _VARIABLE.findall(word)):
        return None
    return _VARIABLE.sub(lambda variable: values[variable[1]], word)


def _entries(kind: str, words: list[str | None], folder: Path) -> list[tuple[str, list[str]]]:
    end = next(
        (at for at, word in enumerate(words) if word and _OPTIONS.fullmatch(word)), len(words)
    )
    sources = [word for word in words[:end] if word is not None]
    if "DESTINATION" not in words or "RENAME" in words:
        return []
    (target, *_) = [*words[words.index("DESTINATION") + 1 :], None]
    if target is None:
        return []
    if kind != "DIRECTORY":
        return [(target, sources)]
    entries = []
    for source in sources:
        # As with rsync: `urdf` is installed as a folder of that name, `urdf/` is what it holds.
        top = target if source.endswith("/") else posixpath.join(target, Path(source).name)
        entries += _files_below(folder, posixpath.normpath(source), top)
    return entries


def _files_below(folder: Path, source: str, target: str) -> list[tuple[str, list[str]]]:
    entries = []
    found = 0
    for root, _, files in os.walk(folder / source):
        below = Path(root).relative_to(folder / source).as_posix()
        entries.append(
            (posixpath.join(target, below), [posixpath.join(source, below, file) for file in files])
        )
        found += len(files)
        if found > _MOST_FILES:
            break
    return entries

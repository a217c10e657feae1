"""Checks of the sizes in MJCF files, before MuJoCo allocates memory for them.

A few characters can mean a height field of 40 GB, or ten million copies of a body, and MuJoCo
cannot be interrupted. So the text and its includes are checked first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from lxml import etree

from teleopctl.base.budget import MOST_COPIES, MOST_PIXELS
from teleopctl.errors import InvalidDescriptionError


class _Size(NamedTuple):
    """Limit of a size that is the product of all numbers in some attributes."""

    attributes: tuple[str, ...]
    most: int
    what: str


# Limits by tag, against 1 GB of memory or 10 s: MuJoCo 4.0 takes 20 bytes for a cell or a pixel.
_SIZES = {
    "camera": _Size(("resolution",), 100_000_000, "pixels"),
    "composite": _Size(("count",), 10_000, "parts"),
    "flexcomp": _Size(("count",), 100_000, "points"),
    "hfield": _Size(("nrow", "ncol"), 16_000_000, "cells"),
    "mesh": _Size(("params",), 1_000_000, "points"),
    "texture": _Size(("width", "height"), MOST_PIXELS, "pixels"),
    "user": _Size(("dim",), 1_000_000, "numbers"),
}
# Attributes of <size> with a number of user values, in total or for each body, joint, ….
_USER_NUMBERS = ("nuserdata", "nuser_")
_MOST_USER_NUMBERS = 1_000_000


def check_mjcf(path: Path) -> None:
    """Check that the sizes in an MJCF file and its includes are within the limits; else raise.

    MuJoCo itself reports other faults.

    Raises:
        InvalidDescriptionError: A size is too large.
    """
    _SizeCheck(path.absolute().parent).check(path.absolute())


def check_mjcf_text(text: str, path: Path) -> None:
    """Check MJCF text as `check_mjcf` checks a file; raise if a size exceeds its limit.

    Args:
        text: MJCF text; includes are relative to the current folder.
        path: Name of the text in error messages.
    """
    reading = _SizeCheck(Path.cwd())
    root = _parsed(text.encode())
    if root is not None:
        reading.check_root(root, path)


class _SizeCheck:
    """Check of an MJCF file and its includes.

    Args:
        folder: Folder that includes are relative to.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._seen: set[Path] = set()
        # Number of elements of each file that can be attached, by its name as an asset.
        self._attached: dict[str, float] = {}

    def check(self, path: Path) -> float:
        """Check an MJCF file; return its number of elements, all replicated copies counted."""
        if path in self._seen:
            return 0.0  # MuJoCo includes no file twice
        self._seen.add(path)
        try:
            root = _parsed(path.read_bytes())
        except OSError:
            return 0.0
        return 0.0 if root is None else self.check_root(root, path)

    def check_root(self, root: etree._Element, path: Path) -> float:
        """Check an MJCF document; return its number of elements, all copies counted."""
        for model in root.iter("model"):
            if file := model.get("file"):
                self._attached[model.get("name") or Path(file).stem] = self._included(file, path)
        for element in root.iter("*"):
            _check_size(element, path)
        return self._count(root, path)

    def _count(self, element: etree._Element, path: Path) -> float:
        """Return the number of elements of a tree, with all copies of ``<replicate>``."""
        counts: dict[etree._Element, float] = {}
        for _, one in etree.iterwalk(element, events=("end",), tag="*"):
            inner = sum(counts.pop(child, 0.0) for child in one)
            if one.tag == "include":
                inner += self._included(one.get("file") or "", path)
            if one.tag == "attach":
                inner += self._attached.get(one.get("model") or "", 0.0)
            if one.tag == "replicate":
                inner *= max(1.0, math.prod(_numbers(one.get("count"))))
                if inner > MOST_COPIES:
                    raise _refusal(one, path, f"makes {inner:.6g} elements", MOST_COPIES)
            counts[one] = inner + 1.0
        return counts[element]

    def _included(self, name: str, path: Path) -> float:
        # MuJoCo resolves includes from the folder of the first file; some files expect their own.
        for folder in (self._folder, path.parent):
            file = (folder / name).resolve()
            if name and file.is_file():
                return self.check(file)
        return 0.0


def _check_size(element: etree._Element, path: Path) -> None:
    if size := _SIZES.get(str(element.tag)):
        asked = math.prod(
            number for name in size.attributes for number in _numbers(element.get(name))
        )
        if asked > size.most:
            raise _refusal(element, path, f"has {asked:.6g} {size.what}", size.most)
    if element.tag == "size":
        for name, value in element.attrib.items():
            if str(name).startswith(_USER_NUMBERS):
                for number in _numbers(str(value)):
                    if number > _MOST_USER_NUMBERS:
                        words = f"requests {number:.6g} numbers in {name}"
                        raise _refusal(element, path, words, _MOST_USER_NUMBERS)


def _refusal(element: etree._Element, path: Path, words: str, most: int) -> InvalidDescriptionError:
    name = element.get("name")
    what = f"<{element.tag} name='{name}'>" if name else f"<{element.tag}>"
    return InvalidDescriptionError(
        f"{path}:{element.sourceline}: {what} {words}, and {most:,} are the most"
    )


def _numbers(text: str | None) -> Iterator[float]:
    """Yield the numbers above 1 of an attribute."""
    for word in (text or "").split():
        try:
            number = float(word)
        except ValueError:
            continue
        if number > 1.0:
            yield number


# Any: lxml returns None for a document without a root.
def _parsed(content: bytes) -> Any:
    parser = etree.XMLParser(
        resolve_entities=False, remove_comments=True, remove_pis=True, huge_tree=True, recover=True
    )
    try:
        return etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError):
        return None
